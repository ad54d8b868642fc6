"""The areas of a geofence: to stay in, and to stay out of.

They come from a mission, or from the items of the mission protocol, and mean the same: all of them
must be obeyed. The simulator's autopilot and the companion use the same code.

Source: PX4 1.16, src/modules/navigator/geofence.cpp. Areas have no altitudes; PX4 reads none.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from companion.geometry import SAME_M, NorthEast, are_alike, horizontal_distance, is_in_polygon

SAGITTA_M = 0.1
"""Largest distance by which a polygon for a circle deviates to the safe side of the circle,"""
LEAST_CORNERS, MOST_CORNERS = 12, 64
"""if these numbers of corners allow: for one circle at least, and for all circles at most."""
ALL_CORNERS = 512


@dataclass(frozen=True, slots=True)
class FencePolygon:
    """A simple polygon of three or more corners; one without corners contains nothing.

    >>> FencePolygon(((0, 0), (0, 2), (2, 2), (2, 0))).contains((1, 1))
    True
    """

    corners: tuple[NorthEast, ...]

    def contains(self, point: Sequence[float]) -> bool:
        """Whether a point lies inside, seen from above."""
        return bool(self.corners) and is_in_polygon(point, self.corners)

    def is_like(self, other: object, within_m: float) -> bool:
        """Whether the corners are the same, from any start and in either direction."""
        if not isinstance(other, FencePolygon) or len(other.corners) != len(self.corners):
            return False
        count = len(self.corners)
        return not count or any(
            all(
                horizontal_distance(corner, other.corners[(first + way * at) % count]) <= within_m
                for at, corner in enumerate(self.corners)
            )
            for way in (1, -1)
            for first in range(count)
        )


@dataclass(frozen=True, slots=True)
class FenceCircle:
    """A circle."""

    centre: NorthEast
    radius_m: float

    def contains(self, point: Sequence[float]) -> bool:
        """Whether a point lies inside, seen from above."""
        return horizontal_distance(point, self.centre) < self.radius_m

    def is_like(self, other: object, within_m: float) -> bool:
        """Whether centre and radius are the same."""
        return (
            isinstance(other, FenceCircle)
            and horizontal_distance(self.centre, other.centre) <= within_m
            and abs(self.radius_m - other.radius_m) <= within_m
        )

    def outline(self, is_inclusion: bool, most: int = MOST_CORNERS) -> tuple[NorthEast, ...]:
        """A polygon for the circle: inside it to stay in, around it to stay out of.

        >>> circle = FenceCircle((0.0, 0.0), 5.0)
        >>> [len(circle.outline(True)), len(circle.outline(True, most=12))]
        [16, 12]
        >>> around = circle.outline(False)
        >>> min(circle.contains(corner) for corner in around), max(n for n, _ in around) < 5.1
        (False, True)
        """
        half = math.acos(1 - min(SAGITTA_M / max(self.radius_m, SAGITTA_M), 1.0))
        count = max(LEAST_CORNERS, min(most, math.ceil(math.pi / half)))
        away_m = self.radius_m / (1.0 if is_inclusion else math.cos(math.pi / count))
        angles = (math.tau * i / count for i in range(count))
        (north, east) = self.centre
        return tuple((north + away_m * math.cos(a), east + away_m * math.sin(a)) for a in angles)


@dataclass(frozen=True, slots=True)
class FenceArea:
    """An area of a fence: to stay in, or to stay out of."""

    shape: FencePolygon | FenceCircle
    is_inclusion: bool

    def allows(self, point: Sequence[float]) -> bool:
        """Whether a point obeys this area."""
        return self.shape.contains(point) == self.is_inclusion

    def is_like(self, other: FenceArea, within_m: float) -> bool:
        """Whether both areas are the same."""
        return self.is_inclusion == other.is_inclusion and self.shape.is_like(other.shape, within_m)


@dataclass(frozen=True, slots=True)
class StoredFence:
    """The fence in an autopilot.

    Attributes:
        areas: in the mission's frame, as the autopilot interprets them.
        points: number of its items.
        flaw: why the autopilot interprets it otherwise than intended; None if it does not.
    """

    areas: tuple[FenceArea, ...]
    points: int
    flaw: str | None = None

    def consists_of(self, areas: Sequence[FenceArea]) -> bool:
        """Whether it has these areas, in any order, and is taken as it was meant.

        >>> square = FenceArea(FencePolygon(((0, 0), (0, 2), (2, 2), (2, 0))), True)
        >>> turned = FenceArea(FencePolygon(((2.1, 2), (2, 0), (0, 0), (0, 2))), True)
        >>> stored = StoredFence((square,), points=4)
        >>> stored.consists_of([turned]), stored.consists_of([turned, square])
        (True, False)
        """
        return self.flaw is None and are_alike(self.areas, areas, SAME_M)

    def __str__(self) -> str:
        return f"{_counted(self.points, 'point')}, {_counted(len(self.areas), 'area')}"


@dataclass(frozen=True, slots=True)
class KeptFence:
    """A fence that is not the mission's and that a flight obeys, as polygons.

    Attributes:
        within: to stay in each of them.
        keep_out: to stay out of each of them.
    """

    within: tuple[tuple[NorthEast, ...], ...]
    keep_out: tuple[tuple[NorthEast, ...], ...]

    def allows(self, point: Sequence[float]) -> bool:
        """Whether a point obeys the whole fence.

        >>> square, bed = ((0, 0), (0, 9), (9, 9), (9, 0)), ((2, 2), (2, 4), (4, 4), (4, 2))
        >>> fence = KeptFence((square,), (bed,))
        >>> fence.allows((1, 1)), fence.allows((3, 3)), fence.allows((-1, 1))
        (True, False, False)
        """
        is_within = all(is_in_polygon(point, area) for area in self.within)
        return is_within and not any(is_in_polygon(point, zone) for zone in self.keep_out)

    @classmethod
    def of(cls, areas: Sequence[FenceArea]) -> KeptFence:
        """The fence of some areas; circles become polygons on their safe side."""
        circles = sum(isinstance(area.shape, FenceCircle) for area in areas)
        most = min(MOST_CORNERS, ALL_CORNERS // max(circles, 1))
        outlines: dict[bool, list[tuple[NorthEast, ...]]] = {True: [], False: []}
        for area in areas:
            shape, is_inclusion = area.shape, area.is_inclusion
            if isinstance(shape, FenceCircle):
                outlines[is_inclusion].append(shape.outline(is_inclusion, most))
            else:
                outlines[is_inclusion].append(shape.corners)
        return cls(tuple(outlines[True]), tuple(outlines[False]))


def _counted(number: int, thing: str) -> str:
    return f"{number} {thing}" if number == 1 else f"{number} {thing}s"
