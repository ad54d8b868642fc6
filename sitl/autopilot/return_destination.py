"""The destination of a return: home, or the nearest rally point.

    RTL_TYPE   destination
    0, 3       the nearest of home and rally points
    1          the nearest rally point; home without one
    2, 4       home

A rally point is ignored if it is within NEAR_HOME_M of home, or if it is not nearer by more than
NEARER_M than the point chosen before it. Distances are horizontal.

Source: PX4 1.16, src/modules/navigator/rtl.cpp (findRtlDestination). Left out: the landing of a
mission (1 to 4), the way back along a mission (2, 4).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from companion.geometry import Ned, NorthEast, horizontal_distance

NEAR_HOME_M = 10.0
NEARER_M = 2.0
HOME_ALONE, WITHOUT_HOME = (2, 4), 1
"""Values of RTL_TYPE."""


@dataclass(frozen=True, slots=True)
class SafePoint:
    """A rally point.

    Attributes:
        up_m: height of the ground there, above home or above the local origin.
    """

    position: NorthEast
    up_m: float
    is_above_home: bool

    def ned(self, home: Ned) -> Ned:
        """Its position, given the present home."""
        return (*self.position, (home[2] if self.is_above_home else 0.0) - self.up_m)


def return_destination(
    position: Ned, home: Ned, safe_points: Sequence[SafePoint], return_type: float
) -> Ned:
    """Where a return from a position lands."""
    destination, nearest_m = home, horizontal_distance(position, home)
    if return_type in HOME_ALONE:
        return home
    if return_type == WITHOUT_HOME:
        nearest_m = math.inf
    for point in safe_points:
        away_m = horizontal_distance(position, point.position)
        is_apart = horizontal_distance(home, point.position) > NEAR_HOME_M
        if is_apart and away_m + NEARER_M < nearest_m:
            destination, nearest_m = point.ned(home), away_m
    return destination
