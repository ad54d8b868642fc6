"""Rally points: where an autopilot's Return may land besides home.

They come from a mission, or from the items of the mission protocol, and mean the same.

Source: https://mavlink.io/en/services/mission.html#rally-points; PX4 1.16, src/modules/navigator/
rtl.cpp, which flies to the nearest of them and home, and takes their altitude as the ground's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from companion.geometry import SAME_M, NorthEast, are_alike, horizontal_distance


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

    def consists_of(self, points: Sequence[RallyPoint]) -> bool:
        """Whether it has these points, in any order, and nothing else.

        >>> here, there = RallyPoint((0.0, 0.0)), RallyPoint((30.0, 0.0))
        >>> stored = StoredRally((here, there))
        >>> stored.consists_of([there, RallyPoint((0.1, 0.1))]), stored.consists_of([here])
        (True, False)
        >>> StoredRally((here,)).consists_of([RallyPoint((0.0, 0.0), up_m=30.0)])
        False
        """
        return self.flaw is None and are_alike(self.points, points, SAME_M)

    def __str__(self) -> str:
        return f"{len(self.points)} rally point{'s' if len(self.points) != 1 else ''}"
