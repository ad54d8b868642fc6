"""Arming, modes and the battery failsafe, as seen from the wire."""

import pytest
from wire import NAN, Wire, gcs_heartbeat

from companion.geometry import horizontal_distance
from companion.mavlink.framing import dialect
from sitl.flight.battery import BatterySpec
from sitl.world.scenario import PX4_HOME, Scenario

ACCEPTED, TEMPORARILY_REJECTED, DENIED, UNSUPPORTED, FAILED = range(5)
FORCE = 21196
NOT_GIVEN = (NAN,) * 7


def airborne(**parameters: float) -> Wire:
    wire = Wire(Scenario(parameters=parameters))
    wire.send(gcs_heartbeat())
    assert wire.command(dialect.MAV_CMD_NAV_TAKEOFF, *NOT_GIVEN) == [ACCEPTED]
    assert wire.arm() == [ACCEPTED]
    wire.run_until(lambda: wire.simulation.mode == "AUTO.LOITER", 10.0)
    return wire


def height(wire: Wire) -> float:
    return -wire.simulation.flight.position[2]


def test_takeoff_without_altitude_climbs_mis_takeoff_alt_and_holds() -> None:
    wire = airborne(MIS_TAKEOFF_ALT=4.0)
    wire.run(4.0)
    assert wire.simulation.mode == "AUTO.LOITER"
    assert height(wire) == pytest.approx(4.0, abs=0.1)


@pytest.mark.parametrize(
    ("above_home_m", "reached_m"), [(-400.0, 2.5), pytest.param(6.0, 6.0, marks=pytest.mark.long)]
)
def test_takeoff_altitude_is_above_the_sea_and_never_below_the_minimum(
    above_home_m: float, reached_m: float
) -> None:
    wire = Wire()
    wire.send(gcs_heartbeat())
    amsl = PX4_HOME.altitude_m + above_home_m
    wire.command(dialect.MAV_CMD_NAV_TAKEOFF, -1, 0, 0, NAN, NAN, NAN, amsl)
    assert ("Using minimum takeoff altitude" in wire.texts()) is (above_home_m < 2.5)
    wire.arm()
    wire.run(12.0)
    assert height(wire) == pytest.approx(reached_m, abs=0.1)


def test_land_disarms_two_seconds_after_touching_down() -> None:
    wire = airborne()
    wire.command(dialect.MAV_CMD_NAV_LAND, *NOT_GIVEN)
    wire.run_until(lambda: "Landing detected" in wire.texts(), 10.0)
    assert wire.run_until(lambda: not wire.simulation.is_armed, 5.0) == pytest.approx(2.0, abs=0.05)
    assert wire.texts()[-1] == "Disarmed by landing"
    assert wire.simulation.mode == "AUTO.LOITER"


def test_after_a_landing_commanded_in_offboard_it_arms_with_setpoints_alone() -> None:
    """Seen on PX4: it goes back to the mode that was intended last and may be armed in."""
    wire = airborne()
    wire.fly_offboard(0.0, 0.0, -2.5)
    wire.command(dialect.MAV_CMD_NAV_LAND, *NOT_GIVEN)
    wire.run_until(lambda: not wire.simulation.is_armed, 15.0)
    assert wire.simulation.mode == "OFFBOARD"
    assert wire.arm() == [TEMPORARILY_REJECTED]
    assert wire.set_mode("AUTO.LOITER")[-1] == ACCEPTED
    assert wire.arm() == [ACCEPTED]


def test_return_comes_home_and_lands_there() -> None:
    wire = airborne(RTL_RETURN_ALT=6.0)
    lat, lon, _ = PX4_HOME.to_global((15.0, 5.0, 0.0))
    wire.command(dialect.MAV_CMD_DO_REPOSITION, -1, 1, 0, NAN, lat, lon, NAN)
    wire.run(10.0)
    assert wire.simulation.flight.position[:2] == pytest.approx((15.0, 5.0), abs=0.3)
    wire.command(dialect.MAV_CMD_NAV_RETURN_TO_LAUNCH)
    peak_m = 0.0
    while wire.simulation.is_armed:
        wire.run(0.1)
        peak_m = max(peak_m, height(wire))
        assert wire.now_s < 60
    assert peak_m == pytest.approx(6.0, abs=0.3)
    assert horizontal_distance(wire.simulation.flight.position, (0, 0)) < 0.2


def test_disarming_in_the_air_needs_force() -> None:
    wire = airborne()
    assert wire.arm(False) == [TEMPORARILY_REJECTED]
    assert wire.texts()[-1] == "Disarming denied: not landed"
    assert wire.arm(False, FORCE) == [ACCEPTED]
    assert not wire.simulation.is_armed
    wire.run(3.0)
    assert wire.simulation.flight.is_on_ground


def test_arming_again_and_disarming_again_are_accepted() -> None:
    wire = Wire()
    assert wire.arm(False) == [ACCEPTED]
    assert wire.arm() == [ACCEPTED]
    assert wire.arm() == [ACCEPTED]


def test_armed_without_takeoff_it_disarms_after_ten_seconds() -> None:
    wire = Wire()
    wire.arm()
    passed_s = wire.run_until(lambda: not wire.simulation.is_armed, 15.0)
    assert passed_s == pytest.approx(10.0, abs=0.1)
    assert wire.simulation.flight.is_on_ground


@pytest.mark.parametrize("mode", ["AUTO.MISSION", "POSCTL", "AUTO.LAND"])
def test_modes_in_which_arming_is_refused(mode: str) -> None:
    wire = Wire()
    assert wire.set_mode(mode) == [ACCEPTED, ACCEPTED]
    assert wire.arm() == [TEMPORARILY_REJECTED]


@pytest.mark.parametrize("mode", ["POSCTL", "AUTO.MISSION"])  # seen on PX4 without RC
def test_modes_that_lack_what_they_need_are_refused_in_the_air(mode: str) -> None:
    wire = airborne()
    assert wire.set_mode(mode) == [ACCEPTED, TEMPORARILY_REJECTED]
    assert wire.simulation.mode == "AUTO.LOITER"


def test_heartbeat_follows_arming_at_once() -> None:
    wire = Wire()
    wire.run(0.5)
    sent_s = wire.now_s
    wire.arm()
    heartbeat = wire.named("HEARTBEAT")[-1]
    assert heartbeat.time_s - sent_s <= 0.01
    assert heartbeat.message.base_mode & 0x80


@pytest.mark.parametrize(
    ("threshold", "action", "mode"),
    [
        ("BAT_CRIT_THR", 3, "AUTO.RTL"),
        pytest.param("BAT_CRIT_THR", 2, "AUTO.LAND", marks=pytest.mark.long),
        pytest.param("BAT_EMERGEN_THR", 3, "AUTO.LAND", marks=pytest.mark.long),
    ],
)
def test_battery_holds_five_seconds_before_it_acts(threshold: str, action: int, mode: str) -> None:
    wire = Wire(Scenario(battery=BatterySpec(0.6), parameters={"COM_LOW_BAT_ACT": action}))
    wire.fly_offboard(6.0, 0.0, -3.0)
    wire.simulation._autopilot.parameters.set(threshold, 0.9)
    wire.run(7.0, send=lambda: wire.setpoint(6, 0, -3))
    (hold_s, hold), (act_s, acts) = wire.mode_changes()[-2:]
    assert (hold, acts) == ("AUTO.LOITER", mode)
    assert act_s - hold_s == pytest.approx(5.0, abs=0.1)  # COM_FAIL_ACT_T
    assert wire.last("HEARTBEAT").system_status == 5


def test_a_low_battery_only_warns() -> None:
    wire = airborne(BAT_LOW_THR=1.0)
    wire.run(6.0)
    assert wire.simulation.mode == "AUTO.LOITER"
    assert wire.last("BATTERY_STATUS").charge_state == 2
    assert wire.last("HEARTBEAT").system_status == 4


def test_the_pilot_takes_over_from_a_battery_failsafe() -> None:
    wire = airborne()
    wire.simulation._autopilot.parameters.set("BAT_CRIT_THR", 1.1)
    wire.run(7.0)
    assert wire.simulation.mode == "AUTO.RTL"
    assert wire.set_mode("AUTO.LOITER") == [ACCEPTED, ACCEPTED]
    wire.run(7.0)
    assert wire.simulation.mode == "AUTO.LOITER"


def test_arming_with_an_almost_empty_battery_is_refused() -> None:
    wire = Wire(Scenario(battery=BatterySpec(0.06)))
    assert wire.arm() == [TEMPORARILY_REJECTED]


def test_notices_fit_into_one_statustext() -> None:
    wire = airborne()
    wire.set_mode("AUTO.MISSION")
    wire.arm(False)
    wire.command(dialect.MAV_CMD_NAV_LAND, *NOT_GIVEN)
    wire.run(12.0)
    wire.set_mode("STABILIZED")
    wire.arm()
    assert len(wire.texts()) > 5
    assert all(len(text) <= 50 for text in wire.texts())


def test_reposition_with_nothing_given_stops_where_it_is() -> None:
    wire = airborne()
    here = wire.simulation.flight.position
    pause = wire.command(dialect.MAV_CMD_DO_REPOSITION, -1, 1, 0, NAN, NAN, NAN, NAN)
    wire.run(3.0)
    assert pause == [ACCEPTED]
    assert wire.simulation.flight.position == pytest.approx(here, abs=0.3)


@pytest.mark.parametrize(
    ("speed_mps", "flown_mps"),
    [
        pytest.param(None, 5.0, marks=pytest.mark.long),
        (2.0, 2.0),
        pytest.param(-1.0, 5.0, marks=pytest.mark.long),
    ],
)
def test_places_are_flown_to_at_cruise_speed(speed_mps: float | None, flown_mps: float) -> None:
    wire = airborne()
    if speed_mps is not None:
        wire.command(dialect.MAV_CMD_DO_CHANGE_SPEED, 1, 3.0, -1)
        wire.command(dialect.MAV_CMD_DO_CHANGE_SPEED, 1, speed_mps, -1)
    latitude, longitude, _ = Scenario().home.to_global((100.0, 0.0, 0.0))
    wire.command(dialect.MAV_CMD_DO_REPOSITION, -1, 1, 0, NAN, latitude, longitude, NAN)
    wire.run(6.0)
    assert wire.simulation.flight.velocity[0] == pytest.approx(flown_mps, abs=0.1)


@pytest.mark.parametrize(
    "delay_s",
    [pytest.param(0.0, marks=pytest.mark.long), 8.0, pytest.param(-1.0, marks=pytest.mark.long)],
)
def test_a_return_waits_at_home_before_it_lands(delay_s: float) -> None:
    wire = Wire(Scenario(parameters={"RTL_LAND_DELAY": delay_s, "RTL_RETURN_ALT": 12.0}))
    wire.fly_offboard(15.0, 0.0, -3.0)
    wire.set_mode("AUTO.RTL")
    at_home_s = wire.run_until(lambda: wire.simulation.flight.position[0] < 2.0, 30.0)
    assert at_home_s > 5.0
    wire.run(6.0)
    height = -wire.simulation.flight.position[2]
    assert height < 7.0 if delay_s == 0 else height == pytest.approx(10.0, abs=0.2)
    wire.run(25.0)
    assert wire.simulation.is_armed == (delay_s < 0)
