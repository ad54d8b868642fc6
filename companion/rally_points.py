"""Rally points: where an autopilot's Return may land besides home.

They come from a mission, or from the items of the mission protocol, and mean the same.

Source: https://mavlink.io/en/services/mission.html#rally-points; PX4 1.16, src/modules/navigator/
rtl.cpp, which flies to the nearest of them and home, and takes their altitude as the ground's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from companion.geometry import NorthEast, horizontal_distance


@dataclass(frozen=True, slots=True)
class RallyPoint:
    """A rally point.

    Attributes:
        up_m: height of the ground there, above home; None if its altitude has another reference.
    """

    position: NorthEast
    up_m: float | None = 0.0

    def is_like(self, other: RallyPoint, within_m: float) -> bool:
        """Whether both are the same, in height too."""
        if self.up_m is None or other.up_m is None:
            return False
        is_level = abs(self.up_m - other.up_m) <= within_m
        return is_level and horizontal_distance(self.position, other.position) <= within_m


@dataclass(frozen=True, slots=True)
class StoredRally:
    """The rally points in an autopilot.

    Attributes:
        points: in the mission's frame.
        flaw: what else is stored among them; None if nothing.
    """

    points: tuple[RallyPoint, ...]
    flaw: str | None = None

    def __str__(self) -> str:
        return f"{len(self.points)} rally point{'s' if len(self.points) != 1 else ''}"


def are_same(these: Sequence[RallyPoint], those: Sequence[RallyPoint], within_m: float) -> bool:
    """Whether two lists have the same points, in any order.

    >>> here, there = RallyPoint((0.0, 0.0)), RallyPoint((30.0, 0.0))
    >>> are_same([here, there], [there, RallyPoint((0.1, 0.1))], 0.2)
    True
    >>> are_same([here], [RallyPoint((0.0, 0.0), up_m=30.0)], 0.2), are_same([here], [], 0.2)
    (False, False)
    """
    if len(these) != len(those):
        return False
    left = list(those)
    for point in these:
        same = next((other for other in left if point.is_like(other, within_m)), None)
        if same is None:
            return False
        left.remove(same)
    return True
