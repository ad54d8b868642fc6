"""What was heard becomes a state: its parts, its frame, and what is never taken over."""

from __future__ import annotations

import math

import pytest
from autopilot import Autopilot, battery

from companion.mavlink.framing import MavlinkCodec, dialect
from companion.vehicle.ports.state import Mode
from companion.vehicle.telemetry import Telemetry
from companion.vehicle.velocity_bias import IGNORED_MPS

EAR = MavlinkCodec(0, 0)


def take(telemetry: Telemetry, datagrams: list[bytes], now_s: float = 0.0) -> None:
    for datagram in datagrams:
        for message in EAR.parse(datagram):
            if telemetry.is_news(now_s, message):
                telemetry.take(now_s, message)


def heard(autopilot: Autopilot, now_s: float = 0.0) -> Telemetry:
    telemetry = Telemetry()
    take(telemetry, autopilot.telemetry(), now_s)
    return telemetry


def say(telemetry: Telemetry, message: object, now_s: float = 1.0) -> None:
    """One more message, after a pause."""
    take(telemetry, [MavlinkCodec(1, 1).pack(message)], now_s)


@pytest.mark.parametrize("missing", range(5))
def test_there_is_no_state_before_every_part_was_heard(missing: int) -> None:
    parts = Autopilot().telemetry()[:5]  # the sixth, the battery, may be unknown
    late = parts.pop(missing)
    telemetry = Telemetry()
    take(telemetry, parts)
    assert telemetry.state is None
    take(telemetry, [late])
    assert telemetry.state is not None


def test_a_state_holds_what_was_said() -> None:
    autopilot = Autopilot()
    autopilot.position, autopilot.velocity = [1.0, 2.0, -3.0], [0.5, -0.5, 0.25]
    autopilot.yaw_rad, autopilot.battery_percent = 1.5, 77
    autopilot.mode, autopilot.is_armed, autopilot.is_landed = "OFFBOARD", True, False
    state = heard(autopilot, now_s=12.5).state
    assert state is not None
    assert state.motion.received_s == 12.5
    assert (state.motion.position, state.motion.velocity) == ((1.0, 2.0, -3.0), (0.5, -0.5, 0.25))
    assert (state.attitude.yaw_rad, state.battery.percent) == (1.5, 77)
    assert (state.heartbeat.mode, state.heartbeat.is_armed, state.is_landed) == (
        Mode.OFFBOARD,
        True,
        False,
    )
    assert not state.heartbeat.is_failsafe


def test_a_velocity_is_what_the_position_tells_in_flight() -> None:
    """The autopilot says 0.3 m/s east of a vehicle whose position does not change."""
    autopilot = Autopilot()
    autopilot.velocity, autopilot.is_landed = [0.0, 0.3, 0.0], False
    telemetry, codec = heard(autopilot), MavlinkCodec(1, 1)
    for number in range(1, 100):
        said = dialect.MAVLink_local_position_ned_message(
            33 * number, *autopilot.position, *autopilot.velocity
        )
        take(telemetry, [codec.pack(said)], number / 30)
    assert telemetry.state is not None
    assert telemetry.state.motion.velocity == pytest.approx((0.0, IGNORED_MPS, 0.0), abs=0.01)


def test_a_critical_charge_is_the_autopilots_own_word() -> None:
    telemetry = heard(Autopilot())
    for charge_state, is_critical in ((0, False), (2, False), (3, True), (4, True), (1, False)):
        told = battery(20)
        told.charge_state = charge_state
        say(telemetry, told)
        assert telemetry.state is not None
        assert telemetry.state.battery.is_critical is is_critical


def test_the_heading_has_a_stamp_of_its_own() -> None:
    """A heading that is not a number renews nothing."""
    telemetry = heard(Autopilot(), now_s=3.0)
    for yaw_rad, stamp_s in ((math.nan, 3.0), (0.5, 4.0)):
        say(telemetry, dialect.MAVLink_attitude_message(0, 0, 0, yaw_rad, 0, 0, 0), 4.0)
        assert telemetry.state is not None
        assert (telemetry.state.attitude.measured_s, telemetry.state.motion.received_s) == (
            stamp_s,
            3.0,
        )


def test_the_stamp_is_that_of_the_position() -> None:
    telemetry = heard(Autopilot(), now_s=1.0)
    heartbeat, *_ = Autopilot().telemetry()
    take(telemetry, [heartbeat], now_s=9.0)
    assert telemetry.state is not None and telemetry.state.motion.received_s == 1.0


def test_positions_are_shifted_to_home_and_back() -> None:
    autopilot = Autopilot()
    autopilot.home, autopilot.position = [10.0, -20.0, 0.5], [11.0, -18.0, -2.5]
    telemetry = heard(autopilot)
    assert telemetry.state is not None
    assert telemetry.state.motion.position == (1.0, 2.0, -3.0)
    assert telemetry.frame.local(telemetry.state.motion.position) == (11.0, -18.0, -2.5)


def test_the_mission_s_frame_does_not_follow_a_home_that_moves() -> None:
    autopilot = Autopilot()
    telemetry = heard(autopilot)
    autopilot.home, autopilot.home_altitude_m = [5.0, 5.0, 0.0], 500.0
    take(telemetry, autopilot.telemetry())
    assert telemetry.frame.origin == (0.0, 0.0, 0.0)
    assert telemetry.frame.altitude_m == 488.0


def test_a_vehicle_that_is_met_in_the_air_has_a_state() -> None:
    """Whatever is heard first: only so can it be seen that it is not ours to take."""
    autopilot = Autopilot()
    autopilot.is_landed = False
    for order in (autopilot.telemetry(), autopilot.telemetry()[::-1]):
        telemetry = Telemetry()
        take(telemetry, order)
        assert telemetry.state is not None and not telemetry.state.is_landed


@pytest.mark.parametrize("number", [math.nan, math.inf])
@pytest.mark.parametrize("what", ["position", "velocity", "yaw_rad", "home"])
def test_what_is_not_finite_is_not_taken_over(what: str, number: float) -> None:
    spoilt = Autopilot()
    setattr(spoilt, what, number if what == "yaw_rad" else [0.0, number, 0.0])
    assert heard(spoilt).state is None
    telemetry = heard(Autopilot())
    known = telemetry.state
    take(telemetry, spoilt.telemetry())
    assert telemetry.state == known


def test_an_undefined_landed_state_is_no_news() -> None:
    telemetry = heard(Autopilot())
    say(telemetry, dialect.MAVLink_extended_sys_state_message(0, 0))
    assert telemetry.state is not None and telemetry.state.is_landed


@pytest.mark.parametrize("landed_state", [2, 3, 4])
def test_only_on_the_ground_is_landed(landed_state: int) -> None:
    telemetry = heard(Autopilot())
    say(telemetry, dialect.MAVLink_extended_sys_state_message(0, landed_state))
    assert telemetry.state is not None and not telemetry.state.is_landed


def test_a_charge_that_stays_unknown_is_none_again() -> None:
    telemetry = heard(Autopilot())
    for now_s, percent, known in ((1.0, 60, 60), (5.9, -1, 60), (6.1, -1, None), (7.0, 50, 50)):
        say(telemetry, battery(percent), now_s)
        assert telemetry.state is not None and telemetry.state.battery.percent == known


def test_an_unknown_charge_is_none_and_later_no_news() -> None:
    autopilot = Autopilot()
    autopilot.battery_percent = -1
    telemetry = heard(autopilot)
    assert telemetry.state is not None and telemetry.state.battery.percent is None
    for percent in (0, -1):
        say(telemetry, battery(percent))
    assert telemetry.state is not None and telemetry.state.battery.percent == 0


@pytest.mark.parametrize(
    ("status", "is_failsafe"),
    [
        (dialect.MAV_STATE_STANDBY, False),
        (dialect.MAV_STATE_ACTIVE, False),
        (dialect.MAV_STATE_CRITICAL, True),
        (dialect.MAV_STATE_EMERGENCY, True),
    ],
)
def test_a_critical_status_is_a_failsafe(status: int, is_failsafe: bool) -> None:
    autopilot = Autopilot()
    autopilot.system_status = status
    state = heard(autopilot).state
    assert state is not None and state.heartbeat.is_failsafe is is_failsafe


def test_a_mode_without_a_name_here_is_another_one() -> None:
    telemetry = heard(Autopilot())
    say(telemetry, dialect.MAVLink_heartbeat_message(2, 12, 1, 0x00FF0000, 4, 3))
    assert telemetry.state is not None and telemetry.state.heartbeat.mode is Mode.OTHER


def test_messages_that_say_nothing_of_the_state_are_ignored() -> None:
    telemetry = heard(Autopilot())
    known = telemetry.state
    say(telemetry, dialect.MAVLink_system_time_message(1, 2), now_s=5.0)
    assert telemetry.state == known


@pytest.mark.parametrize(
    ("roll", "pitch", "yaw", "thrust"),
    [
        pytest.param(0.0, -0.1, 0.0, (0.984, 0.0), id="nose down, north"),
        pytest.param(0.0, -0.1, math.pi / 2, (0.0, 0.984), id="nose down, east"),
        pytest.param(0.1, 0.0, 0.0, (0.0, 0.984), id="right side down, north"),
        pytest.param(0.1, 0.0, math.pi, (0.0, -0.984), id="right side down, south"),
    ],
)
def test_a_tilt_is_an_acceleration(
    roll: float, pitch: float, yaw: float, thrust: tuple[float, float]
) -> None:
    """g tan(0.1) to where the body leans; a vehicle on its side carries nothing."""
    telemetry = heard(Autopilot())
    say(telemetry, dialect.MAVLink_attitude_message(9_000, roll, pitch, yaw, 0.0, 0.0, 0.0))
    assert telemetry.state is not None
    assert telemetry.state.attitude.thrust_mps2 == pytest.approx(thrust, abs=2e-3)
    say(telemetry, dialect.MAVLink_attitude_message(9_100, 1.5, 0.0, yaw, 0.0, 0.0, 0.0), 2.0)
    assert telemetry.state.attitude.thrust_mps2 == pytest.approx(thrust, abs=2e-3)
