"""What a flight between two places costs: the routes of a mission, and their seconds of flight."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from numbers import Real

from companion.arguments import check_kind
from companion.documents import did_you_mean
from companion.errors import CompanionError, MissionError
from companion.mission.facts import HERE, at
from companion.mission.model import Mission
from companion.motion.departure import Departure, at_rest
from companion.motion.layered_routes import LayeredRoutes
from companion.motion.profile import SpeedLimits
from companion.motion.routes import PlaceRegion
from companion.planning.flown_ways import FlownWays
from companion.planning.instances import FlightTime
from companion.slices import spent

LONGEST_S = 1e9
"""Of a flight that a function or a table may say: costs are counted in whole numbers."""
_DISTANCE_US = 30


def route_map(mission: Mission, kind: type[LayeredRoutes] = LayeredRoutes) -> LayeredRoutes:
    """The routes of a mission: the places that its task mentions are not crossed by chance.

    Args:
        mission: whose places they lead to.
        kind: what is made.
    """
    mentioned = mission.task_facts
    sites = {
        name: PlaceRegion(
            place.position,
            place.region,
            is_exclusive=at(name) in mentioned and not place.found_by,
        )
        for name, place in mission.places.items()
    }
    vehicle, limits = mission.vehicle, mission.limits
    return kind(
        mission.grid,
        sites,
        limits.fence,
        vehicle.clearance_m,
        mission.speed_limits,
        vehicle.margin_m,
        limits.keep_out.values(),
        limits.up_m,
    )


def flight_times(
    mission: Mission,
    ways: FlownWays,
    here: Callable[[], Departure | None] = lambda: None,
    limits: Callable[[], SpeedLimits] | None = None,
) -> FlightTime:
    """Seconds of flight between places: as they are flown, where bounds or a battery ask for it.

    All others cost what their length says, which takes a fraction of a millisecond.

    Args:
        mission: whose places they are.
        ways: to its places.
        here: says where the vehicle is, and how it moves, between places.
        limits: says how fast it may fly now; without it as fast as the mission allows.
    """
    as_written, routes = mission.speed_limits, ways.routes

    def flight_time(origin: str, goal: str) -> float:
        departure = here() if origin == HERE else at_rest(routes.goal(origin))
        if departure is None:
            return math.inf
        now = limits() if limits else as_written
        spent(_DISTANCE_US)
        if mission.is_timed or mission.battery is not None:
            return ways.departure_s(departure, goal, now)
        return routes.passage(departure.now.position, goal).duration_s(now)

    return flight_time


def given_times(
    mission: Mission, given: FlightTime | Mapping[tuple[str, str], float]
) -> FlightTime:
    """Flight times as a function or a table has them; without a route between others of a table.

    Args:
        mission: whose places they are about.
        given: seconds of an origin and a goal, or by these two.

    Raises:
        MissionError: the mission does not have a place of the table.
        CompanionError: it is neither; or, also later, what it says is no time.
    """
    table = given if isinstance(given, Mapping) else {}
    if not callable(given):
        check_kind(given, Mapping, "flight times as a function or a table")
    for pair in table:
        if not (isinstance(pair, tuple) and len(pair) == 2):
            raise CompanionError(f"flight times are given by origin and goal, and not by {pair!r}")
        for name in pair:
            if name not in mission.places and name != HERE:
                hint = did_you_mean(name, mission.places)
                raise MissionError(f"no place {name}, of which a flight time is given", hint=hint)

    def flight_time(origin: str, goal: str) -> float:
        seconds = given(origin, goal) if callable(given) else table.get((origin, goal), math.inf)
        check_kind(seconds, Real, f"seconds from {origin} to {goal}")
        if not (0 <= seconds <= LONGEST_S or seconds == math.inf):
            raise CompanionError(f"{seconds} s is no time of a flight from {origin} to {goal}")
        return float(seconds)

    return flight_time
