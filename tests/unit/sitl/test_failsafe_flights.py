"""Each failsafe three times: switched off nothing happens; on, it acts; cleared, as PX4 recovers.

Offboard loss is in test_offboard.py and the battery in test_autopilot.py; the table by itself in
test_failsafes.py.
"""

from collections.abc import Callable

import pytest
from wire import Wire, gcs_heartbeat

from companion.mavlink.framing import dialect
from sitl.flight.estimate import GpsQuality
from sitl.world.scenario import Scenario

LAND, HOLD, RETURN = "AUTO.LAND", "AUTO.LOITER", "AUTO.RTL"


def hovering(**parameters: float) -> Wire:
    wire = Wire(Scenario(parameters=parameters))
    wire.send(gcs_heartbeat())
    wire.fly_offboard(5.0, 0.0, -3.0)
    return wire


def fly_on(wire: Wire, seconds: float, also: Callable[[], object] | None = None) -> None:
    """With setpoints at 50 Hz, and perhaps another message each second."""
    for _ in range(round(seconds)):
        if also:
            wire.send(also())
        wire.run(1.0, send=lambda: wire.setpoint(5.0, 0.0, -3.0))


# -- the ground station ----------------------------------------------------------------------------


@pytest.mark.long
def test_the_loss_of_the_ground_station_is_ignored_by_default() -> None:
    wire = hovering()
    fly_on(wire, 15.0)
    assert wire.simulation.mode == "OFFBOARD"


@pytest.mark.parametrize(
    ("action", "then"),
    [
        pytest.param(1, HOLD, marks=pytest.mark.long),
        (2, RETURN),
        pytest.param(3, LAND, marks=pytest.mark.long),
    ],
)
def test_the_loss_of_the_ground_station(action: int, then: str) -> None:
    wire = hovering(NAV_DLL_ACT=action)
    wire.send(gcs_heartbeat())
    lost_s = wire.now_s
    fly_on(wire, 19.0)
    (held_s, held), *others = wire.mode_changes()[-2 if then != HOLD else -1 :]
    assert held == HOLD
    assert held_s - lost_s == pytest.approx(12.85, abs=0.4)  # seen on PX4
    if then != HOLD:
        ((acted_s, acted),) = others
        assert acted == then
        assert acted_s - held_s == pytest.approx(5.0, abs=0.1)  # COM_FAIL_ACT_T
    assert wire.last("HEARTBEAT").system_status == 5


@pytest.mark.long
def test_the_ground_station_returns_and_so_does_the_mode() -> None:
    wire = hovering(NAV_DLL_ACT=1)
    fly_on(wire, 15.0)
    assert wire.simulation.mode == HOLD
    fly_on(wire, 2.0, gcs_heartbeat)
    assert wire.simulation.mode == "OFFBOARD"
    assert wire.last("HEARTBEAT").system_status == 4


def test_with_that_failsafe_on_arming_needs_a_ground_station() -> None:
    wire = Wire(Scenario(parameters={"NAV_DLL_ACT": 1}))
    assert wire.arm() == [1]
    wire.send(gcs_heartbeat())
    assert wire.arm() == [0]


# -- the position ----------------------------------------------------------------------------------


def lose_gps(wire: Wire, is_lost: bool = True) -> None:
    wire.simulation._estimator.gps = GpsQuality(is_lost, satellites=0 if is_lost else 10)


def test_position_loss_in_offboard_descends_level_and_recovers() -> None:
    """Seen on PX4: ALTCTL 5 to 6 s after the last fix, then it sinks."""
    wire = hovering()
    lose_gps(wire)
    lost_s = wire.now_s
    fly_on(wire, 7.0)
    (acted_s, mode) = wire.mode_changes()[-1]
    assert mode == "ALTCTL"
    assert 5.0 <= acted_s - lost_s <= 6.0
    assert wire.simulation.flight.velocity[2] == pytest.approx(0.5, abs=0.1)
    assert wire.last("GPS_RAW_INT").fix_type == 1
    assert not wire.last("SYS_STATUS").onboard_control_sensors_health & 0x20
    lose_gps(wire, False)
    fly_on(wire, 1.0)
    assert wire.simulation.mode == "OFFBOARD"
    assert wire.last("GPS_RAW_INT").fix_type == 3


def test_a_short_loss_of_the_position_changes_nothing() -> None:
    wire = hovering()
    lose_gps(wire)
    fly_on(wire, 4.0)
    lose_gps(wire, False)
    fly_on(wire, 3.0)
    assert wire.simulation.mode == "OFFBOARD"
    assert wire.simulation.flight.position == pytest.approx((5.0, 0.0, -3.0), abs=0.2)


def test_without_a_position_it_lands_disarms_and_is_not_armed_again() -> None:
    wire = hovering()
    lose_gps(wire)
    wire.run_until(lambda: not wire.simulation.is_armed, 30.0)
    assert wire.set_mode(HOLD) == [0, 0]
    assert wire.arm() == [1]
    assert "Arming denied: GPS fix too low" in wire.texts()


def test_without_a_position_a_hold_becomes_a_blind_landing() -> None:
    wire = hovering()
    wire.set_mode(HOLD)
    lose_gps(wire)
    wire.run(6.0)
    assert wire.mode_changes()[-1][1] == LAND
    assert wire.set_mode("AUTO.RTL") == [0, 1]  # refused: it needs a position


# -- the geofence ----------------------------------------------------------------------------------


def fly_out(wire: Wire) -> None:
    """On to 20 m north, across the fence at 10 m."""
    wire.run_until(
        lambda: wire.simulation.flight.position[0] > 10.1 or wire.simulation.mode != "OFFBOARD",
        20.0,
        send=lambda: wire.setpoint(20.0, 0.0, -3.0),
    )


@pytest.mark.long
def test_without_a_geofence_the_vehicle_goes_where_it_is_told() -> None:
    wire = hovering()
    wire.run(8.0, send=lambda: wire.setpoint(20.0, 0.0, -3.0))
    assert wire.simulation.mode == "OFFBOARD"
    assert wire.simulation.flight.position[0] == pytest.approx(20.0, abs=0.3)


@pytest.mark.parametrize(
    ("action", "then"),
    [
        (1, "OFFBOARD"),
        pytest.param(2, HOLD, marks=pytest.mark.long),
        (3, RETURN),
        pytest.param(5, LAND, marks=pytest.mark.long),
    ],
)
def test_leaving_the_geofence(action: int, then: str) -> None:
    wire = hovering(GF_MAX_HOR_DIST=10, GF_ACTION=action)
    fly_out(wire)
    wire.run(1.0, send=lambda: wire.setpoint(20.0, 0.0, -3.0))
    assert wire.simulation.mode == ("OFFBOARD" if action == 1 else HOLD)
    assert not wire.last("SYS_STATUS").onboard_control_sensors_health & 0x100000
    wire.run(5.0, send=lambda: wire.setpoint(20.0, 0.0, -3.0))
    assert wire.simulation.mode == then
    told = "warning" if action == 1 else "activated"
    assert any(text.startswith(f"Failsafe {told}") for text in wire.texts())


def test_back_inside_the_geofence_the_pilot_gives_a_mode_and_has_the_vehicle() -> None:
    wire = hovering(GF_MAX_HOR_DIST=10, GF_ACTION=3, RTL_RETURN_ALT=3)
    fly_out(wire)
    wire.run(2.0)
    wire.run_until(lambda: wire.simulation.flight.position[0] < 9.0, 30.0)
    assert wire.simulation.mode == RETURN
    wire.set_mode(HOLD)
    wire.run(2.0)
    assert wire.simulation.mode == HOLD
    assert wire.last("HEARTBEAT").system_status == 4


def test_too_high_is_outside_too() -> None:
    wire = hovering(GF_MAX_VER_DIST=4, GF_ACTION=2)
    wire.run(4.0, send=lambda: wire.setpoint(5.0, 0.0, -8.0))
    assert wire.simulation.mode == HOLD


def test_outside_the_geofence_it_is_not_armed() -> None:
    wire = Wire(Scenario(parameters={"GF_MAX_HOR_DIST": 0.01}))
    wire.send(gcs_heartbeat())
    wire.command(dialect.MAV_CMD_DO_SET_HOME, 0, 0, 0, 0, 47.4, 8.5, 488.0)
    assert wire.arm() == [1]
    assert "Arming denied: geofence violation" in wire.texts()


# -- termination, refusals -------------------------------------------------------------------------


def test_offboard_loss_may_stop_the_motors() -> None:
    wire = hovering(COM_OBL_RC_ACT=7)
    wire.run(1.2)
    assert not wire.simulation.is_armed


def test_flight_termination_by_command() -> None:
    wire = hovering()
    assert wire.command(dialect.MAV_CMD_DO_FLIGHTTERMINATION, 0.0) == [0]
    assert wire.simulation.is_armed
    assert wire.command(dialect.MAV_CMD_DO_FLIGHTTERMINATION, 1.0) == [0]
    assert not wire.simulation.is_armed


def test_arming_is_refused_with_a_reason_until_it_is_allowed_again() -> None:
    wire = Wire()
    wire.send(gcs_heartbeat())
    reason = "the propellers are not mounted, says the person who looks after the propellers"
    wire.simulation._autopilot.refuse_arming(reason)
    assert wire.arm() == [1]
    wire.run(1.1)
    assert not wire.last("SYS_STATUS").onboard_control_sensors_health & 0x10000000
    told = [h.message for h in wire.named("STATUSTEXT")]
    assert [m.chunk_seq for m in told] == [0, 1]
    assert len({m.id for m in told} - {0}) == 1
    assert "".join(m.text for m in told) == f"Arming denied: {reason}"
    wire.simulation._autopilot.refuse_arming(None)
    assert wire.arm() == [0]
