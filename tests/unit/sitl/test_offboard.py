"""OFFBOARD as a real PX4 was seen to handle it; the figures are those measurements."""

from typing import Any

import pytest
from wire import VELOCITY_MASK, Wire, gcs_heartbeat

from companion.mavlink.framing import dialect
from sitl.world.scenario import Scenario

ACCEPTED, TEMPORARILY_REJECTED = 0, 1
ALL_IGNORED = 0xDFF


def hovering(**parameters: float) -> Wire:
    wire = Wire(Scenario(parameters=parameters))
    wire.fly_offboard(0.0, 0.0, -3.0)
    return wire


@pytest.mark.parametrize(
    ("action", "loss_s", "mode"),
    [
        (5, 1.0, "AUTO.LOITER"),
        pytest.param(5, 0.3, "AUTO.LOITER", marks=pytest.mark.long),
        pytest.param(5, 3.0, "AUTO.LOITER", marks=pytest.mark.long),
        pytest.param(0, 1.0, "POSCTL", marks=pytest.mark.long),
        (4, 1.0, "AUTO.LAND"),
        pytest.param(3, 1.0, "AUTO.RTL", marks=pytest.mark.long),
    ],
)
def test_loss_of_the_stream_and_its_return(action: int, loss_s: float, mode: str) -> None:
    wire = hovering(COM_OBL_RC_ACT=action, COM_OF_LOSS_T=loss_s)
    last_setpoint_s = wire.now_s
    wire.run(loss_s + 0.5)
    changed_s, changed_to = wire.mode_changes()[-1]
    assert changed_to == mode
    assert loss_s <= changed_s - last_setpoint_s <= loss_s + 0.1  # seen: 9 to 94 ms late
    assert wire.last("HEARTBEAT").system_status == 5  # CRITICAL

    resumed_s = wire.now_s
    wire.run(0.2, send=lambda: wire.setpoint(0, 0, -3))
    changed_s, changed_to = wire.mode_changes()[-1]
    assert changed_to == "OFFBOARD"
    assert changed_s - resumed_s <= 0.04  # seen: 26 to 36 ms
    assert wire.last("HEARTBEAT").system_status == 4  # ACTIVE


def test_another_mode_commanded_meanwhile_is_kept() -> None:
    wire = hovering()
    wire.run(1.5)
    assert wire.simulation.mode == "AUTO.LOITER"
    wire.set_mode("AUTO.LOITER")
    wire.run(1.0, send=lambda: wire.setpoint(0, 0, -3))
    assert wire.simulation.mode == "AUTO.LOITER"
    assert wire.last("HEARTBEAT").system_status == 4


@pytest.mark.parametrize(
    ("rate_hz", "holds"),
    [pytest.param(5.0, True, marks=pytest.mark.long), (1.2, True), (0.9, False)],
)
def test_slow_streams(rate_hz: float, holds: bool) -> None:
    wire = hovering()
    changes = len(wire.mode_changes())
    wire.run(6.0, each_s=1 / rate_hz, send=lambda: wire.setpoint(0, 0, -3))
    assert (len(wire.mode_changes()) == changes) is holds


@pytest.mark.parametrize(
    ("frame", "mask", "down", "is_taken"),
    [
        (8, VELOCITY_MASK, 0.0, True),
        (9, VELOCITY_MASK, 0.0, False),
        pytest.param(7, VELOCITY_MASK, 0.0, False, marks=pytest.mark.long),
        pytest.param(12, VELOCITY_MASK, 0.0, False, marks=pytest.mark.long),
        pytest.param(21, VELOCITY_MASK, 0.0, False, marks=pytest.mark.long),
        pytest.param(8, 0xDF8, -3.0, False, marks=pytest.mark.long),
        (9, 0xDF8, -3.0, False),
        pytest.param(7, 0xDF8, -3.0, False, marks=pytest.mark.long),
        pytest.param(1, ALL_IGNORED, -3.0, False, marks=pytest.mark.long),
        (1, 0xDF8, float("nan"), False),
    ],
)
def test_which_setpoints_count(frame: int, mask: int, down: float, is_taken: bool) -> None:
    wire = hovering()
    wire.run(2.0, send=lambda: wire.setpoint(0.5, 0, down, frame=frame, mask=mask))
    assert wire.simulation.mode == ("OFFBOARD" if is_taken else "AUTO.LOITER")


def test_set_mode_is_answered_twice_within_10_ms() -> None:
    wire = Wire()
    sent_s = wire.now_s
    assert wire.set_mode("OFFBOARD") == [ACCEPTED, ACCEPTED]
    assert wire.named("COMMAND_ACK")[-1].time_s - sent_s <= 0.01


def test_in_the_air_offboard_without_a_stream_is_refused_by_the_second_answer() -> None:
    wire = hovering()
    wire.set_mode("AUTO.LOITER")
    wire.run(2.0)
    assert wire.set_mode("OFFBOARD") == [ACCEPTED, TEMPORARILY_REJECTED]
    assert wire.simulation.mode == "AUTO.LOITER"


def test_disarmed_offboard_is_accepted_without_a_stream_and_arming_refused() -> None:
    wire = Wire()
    wire.send(gcs_heartbeat())
    wire.set_mode("OFFBOARD")
    assert wire.simulation.mode == "OFFBOARD"
    assert wire.arm() == [TEMPORARILY_REJECTED]
    assert not wire.simulation.is_armed
    assert wire.texts() == ["Arming denied: no offboard signal"]


def test_without_a_pilot_posctl_sinks_lands_and_disarms() -> None:
    wire = hovering(COM_OBL_RC_ACT=0)
    wire.run(3.0)
    assert wire.simulation.flight.velocity[2] == pytest.approx(0.5, abs=0.05)
    wire.run_until(lambda: not wire.simulation.is_armed, 12.0)
    assert abs(wire.simulation.flight.position[2]) < 0.05


def test_arm_to_in_air_takes_the_spool_up_and_little_more() -> None:
    wire = Wire()
    wire.send(dialect.MAVLink_command_long_message(1, 1, 511, 0, 245, 20_000, 0, 0, 0, 0, 0))

    def setpoint() -> Any:
        return wire.setpoint(0, 0, -5)

    wire.run(0.2, send=setpoint)
    wire.set_mode("OFFBOARD")
    armed_s = wire.now_s
    wire.arm()
    wire.run(5.0, send=setpoint)
    in_air_s = next(
        h.time_s for h in wire.named("EXTENDED_SYS_STATE") if h.message.landed_state == 2
    )
    # A PX4 needed 2.01 s: it also raises the thrust slowly, which is left out here.
    assert 1.0 < in_air_s - armed_s < 2.01


def test_velocity_in_the_body_frame_follows_the_heading() -> None:
    wire = Wire(Scenario(yaw_rad=1.5707963))  # looks east
    wire.fly_offboard(0.0, 0.0, -3.0)
    wire.run(
        3.0,
        send=lambda: dialect.MAVLink_set_position_target_local_ned_message(
            0, 1, 1, 8, VELOCITY_MASK, 0, 0, 0, 1.0, 0.0, 0.0, 0, 0, 0, 0, 0
        ),
    )
    north, east, _ = wire.simulation.flight.velocity
    assert (north, east) == pytest.approx((0.0, 1.0), abs=0.1)


@pytest.mark.parametrize(
    ("frame", "is_taken"),
    [
        pytest.param(5, True, marks=pytest.mark.long),
        (6, True),
        pytest.param(0, True, marks=pytest.mark.long),
        (11, False),
    ],
)
def test_a_global_setpoint_is_the_same_place(frame: int, is_taken: bool) -> None:
    wire = hovering()
    origin = Scenario().home
    latitude, longitude, altitude = origin.to_global((4.0, 2.0, -5.0))
    height = 5.0 if frame == 6 else altitude
    wire.run(
        6.0,
        send=lambda: dialect.MAVLink_set_position_target_global_int_message(
            0, 1, 1, frame, 0xDF8, round(latitude * 1e7), round(longitude * 1e7), height,
            *(0.0,) * 8,
        ),
    )  # fmt: skip
    expected = (4.0, 2.0, -5.0) if is_taken else (0.0, 0.0, -3.0)
    assert wire.simulation.flight.position == pytest.approx(expected, abs=0.2)
    assert wire.simulation.mode == ("OFFBOARD" if is_taken else "AUTO.LOITER")


@pytest.mark.long
def test_px4_s_own_quadrotor_lags_behind_its_setpoints() -> None:
    """Measured on PX4: 0.5 to 0.6 m at first; our own vehicle hardly does."""

    def lag_m(airframe: str, lasts_s: float) -> float:
        wire = Wire(Scenario(airframe=airframe))
        wire.fly_offboard(0.0, 0.0, -2.5)
        start_s = wire.now_s

        def ahead() -> Any:
            north = wire.now_s - start_s
            return dialect.MAVLink_set_position_target_local_ned_message(
                0, 1, 1, 1, 0xDC0, north, 0.0, -2.5, 1.0, 0.0, 0.0, *(0.0,) * 5
            )

        wire.run(lasts_s, send=ahead)
        return wire.now_s - start_s - wire.simulation.flight.position[0]

    assert abs(lag_m("quad_450", 2.0)) < 0.05
    assert 0.25 < lag_m("px4_sih", 2.0) < 0.6
    assert lag_m("px4_sih", 9.0) < 0.1
