"""Paths: the legs and rounded corners of a route, as functions of the distance along them."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass
from itertools import accumulate

import numpy as np
import numpy.typing as npt

from companion.geometry import Ned, moved
from companion.motion.blends import Blend, PathPoint, ned_of
from companion.motion.rounding import corners
from companion.motion.routes import Route

STRAIGHT: Ned = (0.0, 0.0, 0.0)
"""The curvature of a leg."""


@dataclass(frozen=True, eq=False)
class StraightLeg:
    """The straight part between two corners.

    Attributes:
        begin: its first point.
        direction: of length 1.
        length_m: its length.
    """

    begin: Ned
    direction: Ned
    length_m: float

    def at(self, along_m: float) -> PathPoint:
        """The point at a distance along the leg."""
        return PathPoint(moved(self.begin, self.direction, along_m), self.direction, STRAIGHT)

    def chords(self, from_m: float) -> npt.NDArray[np.float64]:
        """(2, 3) a point on the leg, and its end."""
        return np.array([self.at(from_m).position, self.at(self.length_m).position])


@dataclass(frozen=True, eq=False)
class Turn:
    """A rounded corner."""

    blend: Blend

    @property
    def direction(self) -> Ned:
        """The direction of the leg after the corner, to which the heading turns."""
        return ned_of(self.blend.after)

    @property
    def length_m(self) -> float:
        """The length of the rounded corner."""
        return self.blend.length_m

    def at(self, along_m: float) -> PathPoint:
        """The point at a distance along the corner."""
        return self.blend.at(along_m)

    def chords(self, from_m: float) -> npt.NDArray[np.float64]:
        """(n, 3) points from a distance along the corner to its end."""
        return self.blend.chords(from_m)


class Path:
    """The pieces of a route in the order of flight: a leg, and a turn if its corner is rounded.

    Args:
        route: the route of the path.
        keeps_first_turn: if false, the first corner is not rounded.

    Attributes:
        pieces: empty if the route has no length.
        length_m: total length of the pieces.
    """

    def __init__(self, route: Route, keeps_first_turn: bool = True) -> None:
        waypoints = route.waypoints if route.blends else corners(route.waypoints)
        blends = list(route.blends or (None,) * (len(waypoints) - 2))
        if blends and not keeps_first_turn:
            blends[0] = None
        self._end = waypoints[-1]
        reaches = np.array([0.0, *(blend.reach_m if blend else 0.0 for blend in blends), 0.0])
        self.pieces: list[StraightLeg | Turn] = []
        for index, leg in enumerate(np.diff(waypoints, axis=0)):
            way_m = float(np.linalg.norm(leg))
            if index and (blend := blends[index - 1]):
                self.pieces.append(Turn(blend))
            begin = waypoints[index] + reaches[index] * leg / way_m
            length_m = float(way_m - reaches[index] - reaches[index + 1])
            self.pieces.append(StraightLeg(ned_of(begin), ned_of(leg / way_m), length_m))
        self._begins_m = [0.0, *accumulate(piece.length_m for piece in self.pieces)]
        self.length_m = self._begins_m.pop()

    def begin_m(self, index: int) -> float:
        """The distance along the path at which a piece begins."""
        return self._begins_m[index]

    def at(self, along_m: float) -> PathPoint:
        """The point at a distance along the path; its end beyond that."""
        index = self._index(along_m)
        return self.pieces[index].at(along_m - self._begins_m[index])

    def ahead(self, along_m: float) -> npt.NDArray[np.float64]:
        """(n, 3) points from a distance along the path to its end, n >= 2; chords in the turns."""
        if along_m >= self.length_m:
            return np.array([self._end, self._end])
        index = self._index(along_m)
        here = self.pieces[index].chords(along_m - self._begins_m[index])
        return np.vstack([here, *(piece.chords(0.0)[1:] for piece in self.pieces[index + 1 :])])

    def between(self, begin_m: float, end_m: float) -> npt.NDArray[np.float64]:
        """(n, 3) points from one distance along the path to another, n >= 2; turns as chords."""
        points = self.ahead(begin_m)
        along_m = np.cumsum(np.linalg.norm(np.diff(points, axis=0, prepend=points[:1]), axis=1))
        room_m = max(0.0, end_m - begin_m)
        last = [np.interp(room_m, along_m, axis) for axis in points.T]
        return np.vstack([points[:1], points[1:][along_m[1:] < room_m], last])

    def _index(self, along_m: float) -> int:
        return max(0, bisect_right(self._begins_m, along_m) - 1)
