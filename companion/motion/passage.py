"""Lengths of the route to a place, horizontal and vertical, and the time that it takes."""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.motion.profile import SpeedLimits, flight_time_s

LEVEL_M = 1e-3
"""A route that rises by less is level, and one with a shorter horizontal part is vertical."""


@dataclass(frozen=True, slots=True)
class Passage:
    """Lengths of the route to a place; inf if there is no route.

    Attributes:
        over_ground_m: horizontal length.
        down_m: from its beginning to its end; negative for a climb.
        climb_m: climb on the spot at the beginning, before the level part; None for a sloped route.
    """

    over_ground_m: float
    down_m: float
    climb_m: float | None = None

    @property
    def is_stepped(self) -> bool:
        """Whether it is level between a climb and a descent on the spot."""
        return self.climb_m is not None

    def duration_s(self, limits: SpeedLimits) -> float:
        """Time to fly it from rest to rest; a stepped one has a stop between its parts.

        >>> Passage(0.0, -6.0).duration_s(SpeedLimits(4.0, 2.0, 8.0, climb_mps=2.0))
        4.25
        >>> level = SpeedLimits(2.0, 2.0, 8.0)
        >>> Passage(6.0, -6.0, climb_m=6.0).duration_s(level)
        8.5
        >>> Passage(6.0, 0.0, climb_m=6.0).duration_s(level)
        12.75
        """
        if math.isinf(self.over_ground_m):
            return math.inf
        if self.climb_m is not None:
            upright = (down for down in (-self.climb_m, self.down_m + self.climb_m) if down)
            on_the_spot_s = sum(Passage(0.0, down).duration_s(limits) for down in upright)
            return on_the_spot_s + flight_time_s(self.over_ground_m, limits)
        length_m = math.hypot(self.over_ground_m, self.down_m)
        if abs(self.down_m) < LEVEL_M:
            return flight_time_s(length_m, limits)
        return flight_time_s(length_m, limits.along(self.down_m / length_m))
