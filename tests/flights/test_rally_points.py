"""The safe places of a mission are the autopilot's rally points; its Return goes to the nearest.

The simulator's autopilot has PX4's rules: it stores what it is sent, goes by RTL_TYPE to the
nearest of home and rally points, and passes over what is near home.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from lockstep import VEHICLE, Deaf, Lockstep, Lossy
from moves import MOVE

from companion.acting.sortie.preflight.arming_terms import ArmingTerms, UploadPolicy
from companion.flight_events.rally import (
    RallyKept,
    RallyMissing,
    RallyRemoved,
    RallyReplaced,
    RallyUnused,
    RallyWritten,
)
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import Phase, PhaseEntered
from companion.flights.simulated_world import world_of
from companion.geometry import GlobalOrigin, Ned, horizontal_distance
from companion.mavlink.framing import dialect
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.mission.otherwise import Otherwise
from companion.vehicle.flight_memory import FlightMemory
from sitl.autopilot.return_destination import SafePoint
from sitl.world.scenario import PX4_HOME

RALLY = dialect.MAV_MISSION_TYPE_RALLY
POINT, ABOVE_HOME = dialect.MAV_CMD_NAV_RALLY_POINT, dialect.MAV_FRAME_GLOBAL_RELATIVE_ALT
DATA: dict[str, Any] = {
    "version": 1,
    "name": "meadow",
    "limits": {
        "speed_mps": 5,
        "up_m": [1, 35],
        "fence": [[-10, -10], [60, -10], [60, 30], [-10, 30]],
    },
    "places": {
        "Home": {"east_m": 0, "north_m": 0, "up_m": 3, "radius_m": 2},
        "A": {"east_m": 40, "north_m": 0, "up_m": 3},
        "East": {"east_m": 50, "north_m": 5, "up_m": 4},
        "North": {"east_m": 20, "north_m": 20, "up_m": 5},
    },
    "sets": {"Place": ["Home", "A"]},
    "skills": {"move": MOVE},
    "initially": ["at(Home)"],
    "task": {"visit": "F at(A) & F G at(Home)"},
    "otherwise": {"land_at": ["Home", "East", "North"]},
}
EAST, NORTH = (5.0, 50.0), (20.0, 20.0)
MEADOW = load_mission(DATA)
WITHOUT = replace(MEADOW, otherwise=Otherwise.RETURN_HOME)


def start(
    asked: Mission = MEADOW,
    policy: UploadPolicy = UploadPolicy.UPLOAD,
    own: FlightMemory | None = None,
    world: dict[str, Any] | None = None,
    **options: Any,
) -> Lockstep:
    scenario = world_of(asked, {"version": 1} | (world or {}))
    arming = ArmingTerms(rally_points=policy)
    return Lockstep(asked, scenario, has_station=True, arming=arming, memory=own, **options)


def station_uploads(flight: Lockstep, *points: Ned) -> None:
    """A ground station writes rally points; north, east and metres above home."""
    flight.is_companion_alive = False
    flight.run(0.2)
    flight.station_says(dialect.MAVLink_mission_count_message(VEHICLE, 1, len(points), RALLY))
    for seq, point in enumerate(points):
        flight.run(0.05)
        lat_deg, lon_deg, _ = PX4_HOME.to_global(point)
        x, y = round(lat_deg * 1e7), round(lon_deg * 1e7)
        head = (VEHICLE, 1, seq, ABOVE_HOME, POINT, 0, 1, 0.0, 0.0, 0.0, 0.0)
        flight.station_says(dialect.MAVLink_mission_item_int_message(*head, x, y, point[2], RALLY))
    flight.run(0.2)
    flight.is_companion_alive = True


def points(flight: Lockstep) -> tuple[SafePoint, ...]:
    """Those that the autopilot has."""
    return flight.simulation._autopilot.safe_points


def armed(flight: Lockstep) -> Lockstep:
    return flight.until_reported(PhaseEntered, 60.0, phase=Phase.ARMING)


def refused(flight: Lockstep) -> str:
    flight.until_the_end()
    assert flight.armings == 0 and flight.exit_code == 5
    return flight.ending.text


def lie_at(flight: Lockstep, *expected: tuple[float, float]) -> None:
    stored = points(flight)
    assert len(stored) == len(expected)
    for point, place in zip(stored, expected, strict=True):
        assert horizontal_distance(point.position, place) < 0.05
        assert point.is_above_home and point.up_m == 0.0


def test_they_are_written_before_arming_in_a_second() -> None:
    with_points, without = armed(start()), armed(start(WITHOUT))
    lie_at(with_points, EAST, NORTH)
    assert with_points.one(RallyWritten).points == "East, North"
    assert not with_points.of(RallyUnused)
    assert with_points.now_s - without.now_s < 1.0
    assert points(without) == ()


@pytest.mark.parametrize("seed", range(2))
def test_a_link_that_loses_a_third_delays_it_alone(seed: int) -> None:
    lie_at(armed(start(up=Lossy(0.3, seed), down=Lossy(0.3, 100 + seed))), EAST, NORTH)


def on_earth(home: GlobalOrigin) -> Mission:
    """The same mission in latitude and longitude."""
    places = {
        name: {
            "lat_deg": home.to_global((place["north_m"], place["east_m"], 0.0))[0],
            "lon_deg": home.to_global((place["north_m"], place["east_m"], 0.0))[1],
            "up_m": place["up_m"],
        }
        for name, place in DATA["places"].items()
    }
    fence = [home.to_global((n, e, 0.0))[:2] for e, n in DATA["limits"]["fence"]]
    limits = DATA["limits"] | {"fence": [list(corner) for corner in fence]}
    return load_mission(DATA | {"frame": "wgs84", "places": places, "limits": limits})


@pytest.mark.parametrize("frame", ["enu", "wgs84"])
def test_they_lie_where_they_were_drawn_wherever_the_origin_is(frame: str) -> None:
    home, origin = GlobalOrigin(47.397742, 8.545594, 488.0), GlobalOrigin(47.4112, 8.5283, 455.0)
    world = {"home": degrees(home), "origin": degrees(origin)}
    asked = MEADOW if frame == "enu" else on_earth(home)
    flight = armed(start(asked, world=world))
    if frame == "enu":
        north, east, _ = origin.to_local(home.latitude_deg, home.longitude_deg, 0.0)
        lie_at(flight, *((n + north, e + east) for n, e in (EAST, NORTH)))
    else:
        drawn = (home.to_global((*point, 0.0)) for point in (EAST, NORTH))
        lie_at(flight, *(origin.to_local(*there)[:2] for there in drawn))


def degrees(origin: GlobalOrigin) -> dict[str, float]:
    at = {"latitude_deg": origin.latitude_deg, "longitude_deg": origin.longitude_deg}
    return at | {"altitude_m": origin.altitude_m}


@pytest.mark.parametrize(
    ("from_place", "destination"),
    [pytest.param("A", EAST, marks=pytest.mark.long), ("Home", (0.0, 0.0))],
)
def test_a_pilots_return_goes_to_the_nearest(
    from_place: str, destination: tuple[float, float]
) -> None:
    flight = start()
    flight.until_reported(PhaseEntered, phase=Phase.TASK)
    if from_place == "A":
        flight.until_reported(PlaceReached, place="A")
    flight.station_chooses("AUTO.RTL")
    flight.until(lambda: not flight.simulation.is_armed)
    assert horizontal_distance(flight.simulation.flight.position, destination) < 1.0


def test_a_failsafes_return_goes_there_too() -> None:
    flight = start(world={"parameters": {"COM_OBL_RC_ACT": 3}})
    flight.until_reported(PlaceReached, place="A").kill()
    flight.until(lambda: not flight.simulation.is_armed)
    assert horizontal_distance(flight.simulation.flight.position, EAST) < 1.0


@pytest.mark.long
def test_a_return_type_that_goes_to_none_is_told() -> None:
    flight = start(world={"parameters": {"RTL_TYPE": 2}})
    assert armed(flight).one(RallyUnused).points == "East, North"
    flight.until_reported(PlaceReached, place="A")
    flight.station_chooses("AUTO.RTL")
    flight.until(lambda: not flight.simulation.is_armed)
    assert horizontal_distance(flight.simulation.flight.position, (0.0, 0.0)) < 1.0


def test_somebody_elses_are_refused_with_all_ways_out() -> None:
    flight = start()
    station_uploads(flight, (10.0, 10.0, 0.0))
    reason = refused(flight)
    assert reason.startswith("the vehicle has 1 rally point of somebody else\n")
    assert "--rally-points keep" in reason and "--rally-points replace" in reason
    lie_at(flight, (10.0, 10.0))


@pytest.mark.parametrize("policy", [UploadPolicy.KEEP, UploadPolicy.REPLACE])
def test_they_are_kept_or_replaced_as_the_operator_says(policy: UploadPolicy) -> None:
    flight = start(policy=policy)
    station_uploads(flight, (10.0, 10.0, 0.0))
    armed(flight)
    if policy is UploadPolicy.KEEP:
        assert flight.one(RallyKept).points == "1 rally point"
        lie_at(flight, (10.0, 10.0))
    else:
        assert flight.one(RallyReplaced).before == "1 rally point"
        lie_at(flight, EAST, NORTH)


@pytest.mark.parametrize("policy", [UploadPolicy.KEEP, UploadPolicy.UPLOAD])
def test_the_same_drawn_by_somebody_else_refuse_nothing(policy: UploadPolicy) -> None:
    flight = start(policy=policy)
    station_uploads(flight, (*NORTH, 0.0), (*EAST, 0.0))
    armed(flight)
    if policy is UploadPolicy.KEEP:
        assert flight.one(RallyKept).points == "its rally points at East, North"
        lie_at(flight, NORTH, EAST)
    else:
        assert flight.one(RallyWritten).points == "East, North"
        lie_at(flight, EAST, NORTH)


def test_the_next_mission_replaces_its_own_or_takes_them_away() -> None:
    own = FlightMemory()
    other = load_mission(DATA | {"otherwise": {"land_at": ["Home", "A"]}})
    flight = armed(start(own=own))
    for asked, told in ((other, RallyReplaced), (WITHOUT, RallyRemoved)):
        again = start(asked, own=own)
        again.simulation, again._ticks = flight.simulation, flight._ticks
        again.station_commands(dialect.MAV_CMD_COMPONENT_ARM_DISARM, 0, 21196)
        again.is_companion_alive = False
        again.run(1.0)
        again.is_companion_alive = True
        flight = armed(again)
        assert len(flight.of(told)) == 1
    assert points(flight) == ()


def test_an_autopilot_without_a_position_on_the_earth_is_told_and_flown() -> None:
    deaf = Deaf(dialect.MAVLINK_MSG_ID_GLOBAL_POSITION_INT)
    deaf.is_deaf = True
    flight = armed(start(up=deaf))
    assert flight.one(RallyMissing).reason == "the autopilot reports no position on the earth"
    assert points(flight) == ()


def unsupported(now_s: float, datagrams: list[bytes]) -> list[bytes]:
    """What asks for rally points does not arrive, as on an autopilot that knows none."""
    lists = (dialect.MAVLINK_MSG_ID_MISSION_REQUEST_LIST, dialect.MAVLINK_MSG_ID_MISSION_COUNT)
    return [d for d in datagrams if int.from_bytes(d[7:10], "little") not in lists or d[-3] != 2]


def test_an_autopilot_that_answers_nothing_is_told_with_the_option() -> None:
    flight = start(down=unsupported)
    reason = refused(flight)
    assert reason.startswith("the autopilot does not report its rally points: no answer in")
    assert reason.endswith("\n    --rally-points none leaves them alone")
    armed(start(policy=UploadPolicy.NONE, down=unsupported))


def test_a_mission_without_them_asks_nothing() -> None:
    armed(start(WITHOUT, down=unsupported))
