"""Limits the speed so that the vehicle can stop within what its range finder sees.

The map shows what was known before the flight. Other obstacles are seen by a range finder when the
vehicle is near enough (`RangeScan.reach_m`). So its range limits the speed as soon as scans are
heard, usually before arming. If there are several range finders, the one that sees least counts,
because nobody says which one looks ahead. A vehicle without a range finder sees nothing, and
nothing is promised.

A vehicle that leans into the wind, or against its own drag, looks at the ground ahead, and sees
less. The median of what it has seen in its direction of flight for SUSTAINED_S counts, because it
leans for a moment at each start and stop.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from statistics import median

from companion.acting.flight import Flight
from companion.flight_events.skills import SpeedLimitedBySight
from companion.motion.range_scan import RangeScan
from companion.motion.speed_in_sight import fastest_mps
from companion.vehicle.ports.state import VehicleState

SUSTAINED_S = 2.0
LOOK_S = 0.25
STEP_M = 0.5
"""A smaller change of the range changes nothing."""
MOVING_MPS = 1.0
"""Below this speed a vehicle has no direction of flight."""


class SightLimit:
    """The limit of one flight.

    Args:
        flight: the flight that is slowed.
    """

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self._level_m = self._sight_m = math.inf
        self._told_mps = flight.speed_limit.greatest_mps
        self._seen: deque[tuple[float, float]] = deque()  # time and range

    def take(self, scans: Sequence[RangeScan], state: VehicleState | None) -> None:
        """Takes the scans that were heard, and the motion of the vehicle."""
        if not scans or self._flight.limits.is_beyond_sight:
            return
        self._level_m = min(self._level_m, *(scan.reach_m for scan in scans))
        sight_m = min(self._sight_m, self._level_m)
        if state is not None:
            sight_m = min(self._sustained_m(scans[-1], state, sight_m), self._level_m)
        if sight_m != self._sight_m:
            self._set(sight_m)

    def _sustained_m(self, scan: RangeScan, state: VehicleState, sight_m: float) -> float:
        """The range in the direction of flight; unchanged until a new one has lasted."""
        north_mps, east_mps, _ = state.motion.velocity
        speed_mps, seen, now_s = math.hypot(north_mps, east_mps), self._seen, scan.stamp_s
        if state.is_landed or speed_mps < MOVING_MPS:
            seen.clear()
        elif not seen or now_s - seen[-1][0] >= LOOK_S:
            ahead = north_mps / speed_mps, east_mps / speed_mps
            seen.append((now_s, scan.sight_m(ahead)))
            if now_s - seen[0][0] >= SUSTAINED_S:
                median_m = median(m for _, m in seen)
                while now_s - seen[0][0] >= SUSTAINED_S:
                    seen.popleft()
                return median_m if abs(median_m - sight_m) >= STEP_M else sight_m
        return sight_m

    def _set(self, sight_m: float) -> None:
        """Sets the range; reports only the lowest speed so far."""
        flight, self._sight_m = self._flight, sight_m
        speed_mps = fastest_mps(sight_m, flight.profile)
        flight.speed_limit.set_sight_limit(speed_mps)
        if speed_mps < self._told_mps:
            self._told_mps = speed_mps
            asked_mps = flight.speed_limit.greatest_mps
            flight.report(SpeedLimitedBySight(round(speed_mps, 2), asked_mps, round(sight_m, 2)))
