"""What a flight between two places costs: the routes of a mission and their times of flight."""

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
from companion.planning.flown_routes import FlownRoutes
from companion.planning.instances import FlightTime
from companion.slices import spent

LONGEST_S = 1e9
"""Longest flight that a function or a table may give, because costs are whole numbers."""
_DISTANCE_US = 30


def route_map(mission: Mission, kind: type[LayeredRoutes] = LayeredRoutes) -> LayeredRoutes:
    """The routes of a mission; they cross no region of another place that the task mentions.

    Args:
        mission: the mission with the places.
        kind: the class of the result.
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
    flown_routes: FlownRoutes,
    here: Callable[[], Departure | None] = lambda: None,
    limits: Callable[[], SpeedLimits] | None = None,
) -> FlightTime:
    """Seconds of flight between places; exact, as flown, if time bounds or a battery need it.

    Without these, the cost follows from the length of the route, in a fraction of a millisecond.

    Args:
        mission: the mission with the places.
        flown_routes: routes to its places, and how long they are flown.
        here: says where the vehicle is between places, and how it moves.
        limits: says how fast it may fly now; without it, as fast as the mission allows.
    """
    as_written, routes = mission.speed_limits, flown_routes.routes

    def flight_time(origin: str, goal: str) -> float:
        departure = here() if origin == HERE else at_rest(routes.goal(origin))
        if departure is None:
            return math.inf
        now = limits() if limits else as_written
        spent(_DISTANCE_US)
        if mission.is_timed or mission.battery is not None:
            return flown_routes.departure_s(departure, goal, now)
        return routes.passage(departure.now.position, goal).duration_s(now)

    return flight_time


def given_times(
    mission: Mission, given: FlightTime | Mapping[tuple[str, str], float]
) -> FlightTime:
    """Flight times from a function or a table; pairs that a table lacks have no route.

    Args:
        mission: the mission with the places.
        given: seconds as a function of origin and goal, or a table with these two as the key.

    Raises:
        MissionError: the mission lacks a place of the table.
        CompanionError: it is neither; or a value is not a time (raised when the value is asked
            for).
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
            raise CompanionError(f"{seconds} s is not a time of flight from {origin} to {goal}")
        return float(seconds)

    return flight_time
