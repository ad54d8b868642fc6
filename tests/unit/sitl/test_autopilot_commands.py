"""What each command answers and does; the answers are those of a PX4 (or common.xml's)."""

import pytest
from wire import NAN, Wire, gcs_heartbeat

from companion.mavlink.framing import dialect

ACCEPTED, TEMPORARILY_REJECTED, DENIED, UNSUPPORTED, FAILED = range(5)


@pytest.mark.parametrize(
    ("command", "parameters", "answer"),
    [
        ("MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES", (1.0,), ACCEPTED),
        ("MAV_CMD_REQUEST_PROTOCOL_VERSION", (1.0,), ACCEPTED),
        ("MAV_CMD_GET_HOME_POSITION", (), ACCEPTED),
        ("MAV_CMD_DO_SET_HOME", (1.0,), ACCEPTED),
        ("MAV_CMD_DO_SET_HOME", (0.0, 0.0, 0.0, 0.0, 99.0, 8.5, 480.0), DENIED),
        ("MAV_CMD_DO_SET_HOME", (0.0, 0.0, 0.0, 0.0, 47.0, 8.5, 1e30), DENIED),
        ("MAV_CMD_RUN_PREARM_CHECKS", (), ACCEPTED),
        ("MAV_CMD_DO_CHANGE_SPEED", (1.0, 3.0, -1.0), ACCEPTED),
        ("MAV_CMD_DO_CHANGE_SPEED", (1.0, NAN), DENIED),
        ("MAV_CMD_GET_MESSAGE_INTERVAL", (-5.0,), DENIED),
        ("MAV_CMD_DO_PAUSE_CONTINUE", (0.0,), UNSUPPORTED),
        ("MAV_CMD_DO_SET_MISSION_CURRENT", (2.0,), UNSUPPORTED),
        ("MAV_CMD_USER_1", (), UNSUPPORTED),
    ],
)
def test_answers(command: str, parameters: tuple[float, ...], answer: int) -> None:
    assert Wire().command(getattr(dialect, command), *parameters) == [answer]


def test_older_requests_are_answered_with_their_message() -> None:
    wire = Wire()
    wire.command(dialect.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES, 1.0)
    assert wire.named("AUTOPILOT_VERSION")
    before = len(wire.named("HOME_POSITION"))
    wire.command(dialect.MAV_CMD_GET_HOME_POSITION)
    assert len(wire.named("HOME_POSITION")) == before + 1


@pytest.mark.parametrize(("number", "interval_us"), [(30, 10_000), (0, 1_000_000), (60_000, 0)])
def test_intervals_can_be_asked_for(number: int, interval_us: int) -> None:
    """Of a message that is not streamed, or of no message at all, 0 (seen on PX4)."""
    wire = Wire()
    assert wire.command(dialect.MAV_CMD_GET_MESSAGE_INTERVAL, number) == [ACCEPTED]
    told = wire.last("MESSAGE_INTERVAL")
    assert (told.message_id, told.interval_us) == (number, interval_us)


def test_an_interval_that_is_switched_off_is_0() -> None:
    wire = Wire()
    wire.command(dialect.MAV_CMD_SET_MESSAGE_INTERVAL, 30, -1)
    wire.command(dialect.MAV_CMD_GET_MESSAGE_INTERVAL, 30)
    assert wire.last("MESSAGE_INTERVAL").interval_us == 0


def test_home_can_be_moved_and_the_vehicle_returns_there() -> None:
    wire = Wire()
    wire.fly_offboard(0.0, 0.0, -3.0)
    latitude, longitude, altitude = wire.simulation._vehicle.origin.to_global((6.0, 3.0, 0.0))
    home = (0.0, 0.0, 0.0, 0.0, latitude, longitude, altitude)
    assert wire.command(dialect.MAV_CMD_DO_SET_HOME, *home) == [ACCEPTED]
    wire.command(dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH)
    wire.run_until(lambda: not wire.simulation.is_armed, 60.0)
    assert wire.simulation.flight.position == pytest.approx((6.0, 3.0, 0.0), abs=0.4)


def test_prearm_checks_tell_what_is_wrong() -> None:
    wire = Wire()
    wire.send(gcs_heartbeat())
    wire.set_mode("POSCTL")
    wire.command(dialect.MAV_CMD_RUN_PREARM_CHECKS)
    assert "Preflight Fail: no manual control input" in wire.texts()
