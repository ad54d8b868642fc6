"""Restricts a flight to somebody else's fence that stays in the autopilot.

1. Routes lie inside it, and the gate lets no setpoint out of it; both keep the same distance as
   from the mission's own fence and zones.
2. The mission was planned before this fence was known. If it leaves less room, the plan is searched
   again before arming. Without a plan the mission is refused; the message names the leg that leads
   out, and the area.
3. The journal stores it, because another process that continues the flight cannot ask the autopilot
   in the air.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from companion.acting.executive import Executive
from companion.acting.flight import Flight
from companion.acting.replanning.replanner import PlanFailure
from companion.acting.sortie.beginning import GROUND_SLICE_US
from companion.acting.sortie.preflight.fence_check import FenceJudge
from companion.geofence import KeptFence, StoredFence
from companion.geometry import NorthEast
from companion.outcomes import Failed, Outcome, Progress
from companion.planning.lasso import Lasso
from companion.slices import InSlices, spent

LESS_ROOM = "the vehicle's own fence leaves less room"
STEP_M = 0.1
"""Legs are compared with the areas at points this far apart."""
_ROUTE_US = 3_000


def keep_to(flight: Flight, fence: KeptFence) -> bool:
    """Restricts a flight to a fence from now on; returns whether routes then have less room."""
    flight.kept_fence = fence
    flight.note(fence)
    flight.vehicle.setpoints.keep_within(fence)
    return flight.routes.keep_within(fence.within, fence.keep_out)


class _Leg(NamedTuple):
    """A flight of a plan, as it would have been flown; its route on the ground plan."""

    origin: str
    goal: str
    points: tuple[NorthEast, ...]


class KeptFenceCheck:
    """Applies, before arming, a fence that was kept.

    Args:
        flight: the flight that is restricted.
        executive: has the plan.
        check: the check that has kept the fence.
        home: where the plan begins.
    """

    def __init__(self, flight: Flight, executive: Executive, check: FenceJudge, home: str) -> None:
        self._flight, self._executive = flight, executive
        self._check, self._home = check, home
        self._narrowing: InSlices[Failed | None] | None = None

    def tick(self) -> Outcome:
        """DONE when the plan lies in the fence, if one was kept; or why there is no plan."""
        stored = self._check.kept
        if stored is None:
            return Progress.DONE
        if self._narrowing is None:
            self._narrowing = InSlices(lambda: self._narrow(stored), GROUND_SLICE_US)
        if not self._narrowing.step():
            return Progress.RUNNING
        return self._narrowing.result or Progress.DONE

    def _narrow(self, stored: StoredFence) -> Failed | None:
        legs = list(self._legs(self._executive.lasso))
        if not keep_to(self._flight, KeptFence.of(stored.areas)):
            return None
        failure = self._executive.plan_again(LESS_ROOM)
        return self._refused(failure, legs, stored) if failure is not None else None

    def _legs(self, plan: Lasso | None) -> Iterator[_Leg]:
        """The flights of a plan, each once; none for a tree that was written by hand."""
        routes, told = self._flight.routes, set[tuple[str, str]]()
        actions = (*plan.prefix, *plan.loop, *plan.loop) if plan is not None else ()
        flown_to = (action.destination for action in actions if action.destination is not None)
        for origin, goal in pairwise((self._home, *flown_to)):
            if (origin, goal) in told or not (routes.knows(origin) and routes.knows(goal)):
                continue
            told.add((origin, goal))
            spent(_ROUTE_US)
            if (route := routes.route(routes.goal(origin), goal)) is not None:
                yield _Leg(origin, goal, tuple((n, e) for n, e, _ in route.waypoints.tolist()))

    def _refused(self, failure: PlanFailure, legs: list[_Leg], stored: StoredFence) -> Failed:
        routes = self._flight.routes
        lost = (leg for leg in legs if routes.route(routes.goal(leg.origin), leg.goal) is None)
        leg = next(lost, None)
        where = f": {_leaves(leg, stored)}" if leg is not None else ""
        return Failed(f"no plan within the vehicle's own fence ({stored}){where}\n{failure}")


def _leaves(leg: _Leg, stored: StoredFence) -> str:
    """The area that a leg leaves or crosses, in words."""
    way = f"the way from {leg.origin} to {leg.goal}"
    for (n1, e1), (n2, e2) in pairwise(leg.points):
        count = 2 + int(np.hypot(n2 - n1, e2 - e1) / STEP_M)
        for point in zip(np.linspace(n1, n2, count), np.linspace(e1, e2, count), strict=True):
            for number, area in enumerate(stored.areas, 1):
                if not area.allows(point):
                    does = "leaves" if area.is_inclusion else "crosses"
                    return f"{way} {does} area {number} of {len(stored.areas)}"
    return f"{way} comes too near to its edge"
