"""Chooses the clearance of a route: more clearance may make it longer, but not by much.

The route at the highest level may be four times as long, for a tenth of a metre more beside one
gap. So if the whole added clearance makes the route more than a tenth longer, two thirds of it are
enough: two deviations of the position instead of three. If no route keeps that much, the highest
level that leads to the place is flown.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

from companion.geometry import NorthEast
from companion.motion.clearance_level import ClearanceLevel, RouteEntry, is_enough

DETOUR = 1.1
"""A route may be this many times as long to keep the whole added clearance."""


@dataclass
class RouteAtClearance:
    """A route at one clearance; its properties are searched when first asked for, and once.

    Args:
        level: its clearance level.
        start: where it begins.
        place: where it leads.
    """

    level: ClearanceLevel
    start: NorthEast
    place: str

    @cached_property
    def entry(self) -> RouteEntry | None:
        """Where the route enters free cells; None if there is no route."""
        return self.level.entry(self.start, self.place)

    @property
    def length_m(self) -> float:
        """Its length in the plane; inf if there is no route."""
        return math.inf if self.entry is None else self.entry.length_m


def decisive_routes(
    levels: Sequence[ClearanceLevel], start: NorthEast, place: str, straight_m: float
) -> Iterator[RouteAtClearance]:
    """The routes that decide which one is flown; each may be searched before it is examined.

    The last one is flown: the one at the highest level that is not DETOUR times as long as the one
    that keeps ENOUGH_SHARE of the added clearance. A route is never shorter at a higher level, nor
    shorter than a straight line.

    Args:
        levels: the highest first.
        start: where the route begins.
        place: where it leads.
        straight_m: length of the straight line there.
    """
    routes = [RouteAtClearance(level, start, place) for level in levels]
    yield routes[0]
    is_direct = routes[0].length_m <= DETOUR * straight_m
    if is_direct or not levels[-1].is_connected(start, place):
        return
    least_m = levels[-1].clearance_m
    added_m = levels[0].clearance_m - least_m
    *_, enough = (
        route for route in routes if is_enough(route.level.clearance_m - least_m, added_m)
    )
    yield enough
    most_m = DETOUR * enough.length_m
    for route in routes:
        yield route
        if math.isfinite(route.length_m) and route.length_m <= most_m:
            return
