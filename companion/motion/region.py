"""The region of a place: where `at(place)` holds. Its two kinds, and all that is asked of them.

Planner, routes, symbols, the watch over the vehicle's whereabouts and the pages ask here, so that
they mean the same. Positions are metres in the mission's frame; the centre of a region is the
place's own point, which may move (symbols do not move it).
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
    """Where a place is, about its centre."""

    def away_m(self, centre: Ned, position: Ned) -> float:
        """How far outside a position is; at most 0 inside."""

    def inner_m(self, centre: Ned) -> float:
        """Radius of the disc about the centre that lies inside."""

    def waypoints(self, centre: Ned, count: int, inside_m: float) -> Iterator[Ned]:
        """At most so many points spread over it, so far inside, from its centre outwards."""

    def outline(self) -> tuple[NorthEast, ...] | None:
        """Its corners; None of a disc."""


@dataclass(frozen=True, slots=True)
class Disc:
    """All points within a radius; over the ground a disc, in the air a ball."""

    radius_m: float

    def away_m(self, centre: Ned, position: Ned) -> float:
        """By the distance in space."""
        return distance(centre, position) - self.radius_m

    def inner_m(self, centre: Ned) -> float:
        """Its radius."""
        return self.radius_m

    def waypoints(self, centre: Ned, count: int, inside_m: float) -> Iterator[Ned]:
        """Vogel's spiral."""
        return _spiral(centre, count, max(0.0, self.radius_m - inside_m))

    def outline(self) -> None:
        """A disc has no corners."""
        return


@dataclass(frozen=True)
class Area:
    """All points over a polygon, at whatever height."""

    corners: tuple[NorthEast, ...]

    def away_m(self, centre: Ned, position: Ned) -> float:
        """By the distance over the ground."""
        gap_m = self._gap_m(position)
        return -gap_m if is_in_polygon(position, self.corners) else gap_m

    def inner_m(self, centre: Ned) -> float:
        """As far as its nearest edge is."""
        return max(0.0, -self.away_m(centre, centre))

    def waypoints(self, centre: Ned, count: int, inside_m: float) -> Iterator[Ned]:
        """Those of Vogel's spiral that lie inside."""
        reach_m = max(math.dist(centre[:2], corner) for corner in self.corners)
        points = _spiral(centre, count, reach_m)
        return (point for point in points if self.away_m(centre, point) <= -inside_m)

    def outline(self) -> tuple[NorthEast, ...]:
        """Its corners."""
        return self.corners

    def _gap_m(self, position: Ned) -> float:
        return float(distance_to_edges(np.array(position[:2]), self._points))

    @cached_property
    def _points(self) -> Points:
        return np.array(self.corners)


def _spiral(centre: Ned, count: int, reach_m: float) -> Iterator[Ned]:
    """Points spread evenly over a disc, from its middle outwards (Vogel 1979)."""
    north, east, down = centre
    for i in range(1, count + 1):
        away_m, angle = reach_m * math.sqrt(i / count), i * _GOLDEN_RAD
        yield (north + away_m * math.cos(angle), east + away_m * math.sin(angle), down)
