"""How far a vehicle is off the path that its setpoints describe.

A vehicle that only lags behind its setpoint is still on its path. So what counts is the horizontal
distance to where its setpoints have led in the last seconds. The largest distance counts for this
period and the next, because the vehicle oscillates, and gusts return. The result is rounded to
steps, because each change makes new routes necessary.
"""

from __future__ import annotations

import math
from collections import deque
from itertools import pairwise

from companion.geometry import NorthEast

LOOK_S = 0.25
"""Time between two measurements; a vehicle oscillates over seconds."""
PATH_S = 3.0
"""How long a setpoint counts as part of the path: no vehicle lags further behind. A vehicle that
others have moved may also take so long to return to its path."""
PERIOD_S = 60.0
"""The largest distance counts for at least so long, and at most twice as long."""
STEP_M = 0.2
"""The result is a multiple of this."""


class TrackingError:
    """The tracking error of one vehicle.

    Args:
        jump_m: setpoints further apart than this do not form a path.
    """

    def __init__(self, jump_m: float) -> None:
        self._jump_m = jump_m
        self._path: deque[tuple[float, NorthEast]] = deque()
        self._most_m = self._before_m = 0.0  # the largest of this period and of the one before
        self._begin_s: float | None = None
        self._look_s = self._paused_s = -math.inf

    @property
    def off_m(self) -> float:
        """How far the vehicle was off its path at most, rounded to a step."""
        return round(STEP_M * round(max(self._most_m, self._before_m) / STEP_M), 9)

    def pause(self, now_s: float) -> None:
        """Interrupts the measurement: there is no setpoint, or the position is unknown."""
        self._path.clear()
        self._paused_s = now_s

    def follow(self, now_s: float, told: NorthEast, here: NorthEast) -> None:
        """Takes the setpoint and the position of the vehicle; once in each tick."""
        if now_s - self._look_s < LOOK_S:
            return
        self._look_s = now_s
        while self._path and self._path[0][0] < now_s - PATH_S:
            self._path.popleft()
        if self._path and math.dist(self._path[-1][1], told) > self._jump_m:
            self._path.clear()
        self._path.append((now_s, told))
        if now_s - self._paused_s < PATH_S:
            return
        points = [point for _, point in self._path]
        legs = pairwise(points) if len(points) > 1 else [(told, told)]
        if self._begin_s is None or now_s >= self._begin_s + PERIOD_S:
            self._begin_s, self._before_m, self._most_m = now_s, self._most_m, 0.0
        self._most_m = max(self._most_m, min(_away_m(here, *leg) for leg in legs))


def _away_m(point: NorthEast, begin: NorthEast, end: NorthEast) -> float:
    """Distance from a point to a straight leg.

    >>> _away_m((1.0, 1.0), (0.0, 0.0), (4.0, 0.0)), _away_m((7.0, 4.0), (0.0, 0.0), (4.0, 0.0))
    (1.0, 5.0)
    """
    north, east = end[0] - begin[0], end[1] - begin[1]
    length_2 = north * north + east * east
    along = (point[0] - begin[0]) * north + (point[1] - begin[1]) * east
    share = min(1.0, max(0.0, along / length_2)) if length_2 else 0.0
    return math.dist(point, (begin[0] + share * north, begin[1] + share * east))
