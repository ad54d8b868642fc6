"""How long routes take as they are actually flown, including bends.

Where a route leads around obstacles, its length alone says too little: in a hall the vehicle slows
down in bends and needs up to 1.7 times as long. To find a route takes some milliseconds. So a route
between places is kept as long as the length of the shortest path stays the same.

A first leg that begins in motion is computed as it is flown, by the rules of `motion/departure.py`.
"""

from __future__ import annotations

import math
from functools import lru_cache

from companion.geometry import Ned
from companion.motion.departure import Departure, from_motion, gentle, is_slow
from companion.motion.layered_routes import LayeredRoutes
from companion.motion.passage import Passage
from companion.motion.profile import SpeedLimits
from companion.motion.routes import Route
from companion.motion.trajectory import Trajectory
from companion.slices import spent

_ROUTE_US, _TRAJECTORY_US = 5_000, 130
ARRIVAL_S = 0.15
"""Average time from the end of a trajectory until the vehicle is seen to have arrived."""
_KEPT = 4_096
"""Number of routes that are kept; enough for all pairs of 64 places."""
_DEPARTURES_KEPT = 64
"""Routes kept from the present state of the vehicle: one to each place, for time and energy."""
_TURNING_STEP_S = 0.05


class FlownRoutes:
    """Routes to places, and how long their trajectories last.

    Attributes:
        routes: the routes that are flown.

    Args:
        routes: the routes that are flown.
    """

    def __init__(self, routes: LayeredRoutes) -> None:
        self.routes = routes
        self._route = lru_cache(_KEPT)(self._find)
        self._duration_s = lru_cache(_KEPT)(_duration_s)
        self._from_motion_s = lru_cache(_DEPARTURES_KEPT)(self._find_from_motion_s)
        self._bends_s = lru_cache(_KEPT)(self._find_bends_s)

    def flight_s(self, start: Ned, place: str, limits: SpeedLimits) -> float:
        """Seconds from rest at `start` until the vehicle has arrived; inf without a route."""
        passage = self.routes.passage(start, place)
        if math.isinf(passage.over_ground_m):
            return math.inf
        route = self._route(start, place, self.routes.goal(place), passage)
        return math.inf if route is None else self._duration_s(route, limits) + ARRIVAL_S

    def bends_s(self, start: Ned, place: str, limits: SpeedLimits) -> float:
        """How many seconds longer a flight takes than its length suggests; 0 without a route."""
        return self._bends_s(start, place, self.routes.goal(place), limits, self.routes.version)

    def departure_s(self, departure: Departure, place: str, limits: SpeedLimits) -> float:
        """Seconds from a departure until the vehicle has arrived; inf without a route."""
        if departure.stop is None and is_slow(departure.now):
            return self.flight_s(departure.now.position, place, limits)
        version = self.routes.version
        return self._from_motion_s(departure, place, self.routes.goal(place), limits, version)

    def _find_from_motion_s(
        self, departure: Departure, place: str, goal: Ned, limits: SpeedLimits, version: int
    ) -> float:
        """The same for a moving vehicle: from its first straight stretch, or from its stop."""
        turning_s = 0.0
        while departure.is_turning:
            turning_s += _TURNING_STEP_S
            departure = departure.later(_TURNING_STEP_S)
        if not is_slow(departure.now):
            spent(_ROUTE_US + _TRAJECTORY_US)
            now = departure.now
            if flown := from_motion(self.routes, now, place, gentle(limits, now)):
                return turning_s + flown.duration_s + ARRIVAL_S
        rest, rests_in_s = departure.rest
        return turning_s + rests_in_s + self.flight_s(rest, place, limits)

    def _find_bends_s(
        self, start: Ned, place: str, goal: Ned, limits: SpeedLimits, version: int
    ) -> float:
        flown_s = self.flight_s(start, place, limits)
        by_length_s = self.routes.passage(start, place).duration_s(limits)
        return max(0.0, flown_s - by_length_s) if math.isfinite(flown_s) else 0.0

    def _find(self, start: Ned, place: str, goal: Ned, passage: Passage) -> Route | None:
        """The present route to a place, if it is as long as was measured.

        It is found in the slice in which that was measured, because the map may change later.
        """
        route = self.routes.route(start, place)
        spent(_ROUTE_US)
        return route


def _duration_s(route: Route, limits: SpeedLimits) -> float:
    spent(_TRAJECTORY_US)
    return Trajectory(route, limits).duration_s
