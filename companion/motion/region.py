"""The region of a place, in which `at(place)` holds: its two kinds, and their operations.

Planner, routes, symbols, the check of where the vehicle is, and the pages all use this module, so
that they agree. Positions are metres in the mission's frame. The centre of a region is the place's
own point, which may move (symbols do not move it).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from companion.geometry import Ned, NorthEast, distance, is_in_polygon
from companion.motion.line_of_sight import Points
from companion.motion.polygons import distance_to_edges

_GOLDEN_RAD = math.pi * (3 - math.sqrt(5))


class Region(Protocol):
    """The area of a place, relative to its centre."""

    def away_m(self, centre: Ned, position: Ned) -> float:
        """How far outside the region a position is; at most 0 inside."""

    def inner_m(self, centre: Ned) -> float:
        """Radius of the largest disc around the centre that lies inside."""

    def waypoints(self, centre: Ned, count: int, inside_m: float) -> Iterator[Ned]:
        """At most `count` points spread over it, `inside_m` from its edge, the centre first."""

    def outline(self) -> tuple[NorthEast, ...] | None:
        """The corners of the region; None for a disc."""


@dataclass(frozen=True, slots=True)
class Disc:
    """All points within a radius: on the ground plan a disc, in the air a ball."""

    radius_m: float

    def away_m(self, centre: Ned, position: Ned) -> float:
        """From the distance in space."""
        return distance(centre, position) - self.radius_m

    def inner_m(self, centre: Ned) -> float:
        """Its radius."""
        return self.radius_m

    def waypoints(self, centre: Ned, count: int, inside_m: float) -> Iterator[Ned]:
        """Points on Vogel's spiral."""
        return _spiral(centre, count, max(0.0, self.radius_m - inside_m))

    def outline(self) -> None:
        """A disc has no corners."""
        return


@dataclass(frozen=True)
class Area:
    """All points above a polygon, at any height."""

    corners: tuple[NorthEast, ...]

    def away_m(self, centre: Ned, position: Ned) -> float:
        """From the horizontal distance."""
        gap_m = self._gap_m(position)
        return -gap_m if is_in_polygon(position, self.corners) else gap_m

    def inner_m(self, centre: Ned) -> float:
        """The distance to the nearest edge."""
        return max(0.0, -self.away_m(centre, centre))

    def waypoints(self, centre: Ned, count: int, inside_m: float) -> Iterator[Ned]:
        """The points of Vogel's spiral that lie inside."""
        reach_m = max(math.dist(centre[:2], corner) for corner in self.corners)
        points = _spiral(centre, count, reach_m)
        return (point for point in points if self.away_m(centre, point) <= -inside_m)

    def outline(self) -> tuple[NorthEast, ...]:
        """The corners of the polygon."""
        return self.corners

    def _gap_m(self, position: Ned) -> float:
        return float(distance_to_edges(np.array(position[:2]), self._points))

    @cached_property
    def _points(self) -> Points:
        return np.array(self.corners)


def _spiral(centre: Ned, count: int, reach_m: float) -> Iterator[Ned]:
    """Points spread evenly over a disc, from its centre outwards (Vogel 1979)."""
    north, east, down = centre
    for i in range(1, count + 1):
        away_m, angle = reach_m * math.sqrt(i / count), i * _GOLDEN_RAD
        yield (north + away_m * math.cos(angle), east + away_m * math.sin(angle), down)
