"""Keeps the vehicle itself off walls, not only its setpoint, in flight and while it holds.

Each setpoint passes here on its way to the gate. It is moved by what `wall_push.py` says, as far as
fences, zones and other walls allow. Trajectories continue from the setpoint before it was moved.
"""

from __future__ import annotations

import math

from companion.flight_events.skills import WallNear
from companion.geometry import Ned, NorthEast
from companion.motion.grid import OccupancyGrid
from companion.motion.layered_routes import LayeredRoutes
from companion.motion.routes import RouteMap
from companion.motion.trajectory import Sample
from companion.motion.wall_push import STILL, push
from companion.vehicle.ports.state import VehicleState
from companion.vehicle_profile import VehicleProfile

CLEAR_AGAIN_M = 0.1
"""With this much more than its margin the vehicle has left a wall, and may be reported again."""
SHARES = (1.0, 0.75, 0.5, 0.25)
"""Shares of the move that are tried; the first one that leads into nothing else is used."""
TOLD_M = 0.3
"""A smaller move, as for a vehicle that falls behind a little, is not reported."""
NEARER_M = 0.2
"""A vehicle nearer to a wall than its setpoint by less than this counts as at its setpoint."""
SOON_S = 1.0
"""How far ahead the vehicle's motion is examined: an autopilot needs about that time to stop it."""


class WallGuard:
    """The guard of one flight.

    Args:
        routes: know the walls.
        profile: the vehicle's profile.
    """

    def __init__(self, routes: LayeredRoutes, profile: VehicleProfile) -> None:
        self._routes, self._profile = routes, profile
        self._is_near = False

    def kept_off(self, told: Sample, state: VehicleState | None) -> tuple[Ned, WallNear | None]:
        """Where to send a setpoint; and an event, if the vehicle is near a wall."""
        if state is None or state.is_landed:
            return told.position, None
        plane = self._routes.plane(-told.position[2])
        if plane is None:
            return told.position, None
        kept_m, carrot_m = self._routes.kept_m, self._profile.carrot_m
        by = push(plane.obstacles, kept_m, state.motion.position, told, carrot_m)
        sent = self._moved(plane, told.position, by)
        if not self._is_near and math.dist(sent, told.position) < TOLD_M:
            return sent, None
        return sent, self._news(plane.obstacles, state)

    def is_approached(self, told: Ned, state: VehicleState) -> bool:
        """Whether the vehicle is nearer to a wall than its setpoint, or will be, as it moves now.

        Not if it is far from all walls: further than routes keep, plus its distance from its
        setpoint, which is how far it can swing.
        """
        plane = self._routes.plane(-told[2])
        if plane is None:
            return False
        (north, east, _), (v_north, v_east, _) = state.motion.position, state.motion.velocity
        off_m = math.dist((north, east), told[:2])
        asked_m = min(self._routes.kept_m + off_m, plane.obstacles.clearance_m(told[:2])) - NEARER_M
        soon = (north + SOON_S * v_north, east + SOON_S * v_east)
        return any(plane.obstacles.is_within(at, asked_m) for at in ((north, east), soon))

    def _moved(self, plane: RouteMap, position: Ned, by: NorthEast) -> Ned:
        """The setpoint, moved as far as fences, zones and walls allow.

        A move away from a wall on one side of a passage may meet the wall on the other side.
        """
        north, east, down = position
        if by == STILL:
            return position
        body_m = min(self._profile.radius_m, plane.obstacles.clearance_m((north, east)))
        for share in SHARES:
            moved = (north + share * by[0], east + share * by[1])
            if plane.is_usable(moved) and not plane.obstacles.is_within(moved, body_m):
                return (*moved, down)
        return position

    def _news(self, obstacles: OccupancyGrid, state: VehicleState) -> WallNear | None:
        """The event, once for each time that the vehicle, off its route, lacks its margin."""
        was_near, needed_m = self._is_near, self._profile.radius_m + self._profile.margin_m
        here = state.motion.position[:2]
        again_m = needed_m + (CLEAR_AGAIN_M if was_near else 0.0)
        self._is_near = obstacles.is_within(here, again_m)
        if was_near or not self._is_near:
            return None
        return WallNear(round(obstacles.clearance_m(here) - self._profile.radius_m, 3))
