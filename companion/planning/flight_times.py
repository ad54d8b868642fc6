"""What a flight between two places costs: the routes of a mission, and their seconds of flight."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from companion.documents import did_you_mean
from companion.errors import MissionError, check_kind
from companion.mission.facts import HERE, at
from companion.mission.model import Mission
from companion.motion.departure import Departure, at_rest
from companion.motion.layered_routes import LayeredRoutes
from companion.motion.profile import SpeedLimits
from companion.motion.routes import PlaceRegion
from companion.planning.flown_ways import FlownWays
from companion.planning.instances import FlightTime
from companion.slices import spent

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


def from_table(mission: Mission, table: Mapping[tuple[str, str], float]) -> FlightTime:
    """Flight times as a table has them: seconds by origin and goal; no route between others.

    Raises:
        MissionError: the mission does not have a place of the table.
        CompanionError: it is no table.
    """
    check_kind(table, Mapping, "flight times as a function or a table")
    for pair in table:
        for name in pair:
            if name not in mission.places and name != HERE:
                hint = did_you_mean(name, mission.places)
                raise MissionError(f"no place {name}, of which a flight time is given", hint=hint)
    return lambda origin, goal: table.get((origin, goal), math.inf)
