"""Blends: a corner between two legs, rounded by two clothoids.

The first clothoid leaves the first leg with zero curvature, which then grows linearly along it. The
second is its mirror image and joins the second leg. At a constant speed v the lateral acceleration
rises and falls linearly, from zero to zero, as it does along a leg with limited jerk. So neither
velocity nor acceleration jumps anywhere. With the turn T, and the length L of both together,

    greatest curvature k = 2 T / L,   v^2 k <= acceleration,   v^3 2 k / L <= jerk

(Shin and Singh, Path Generation for Robot Vehicles Using Composite Clothoid Segments, 1990; Walton
and Meek, A controlled clothoid spline, Computers and Graphics 29, 2005). Points on them are Fresnel
integrals. Left out: the jerk along the path, v^3 k^2, which is at most T times the lateral one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple, overload

import numpy as np
import numpy.typing as npt
from scipy.special import fresnel

from companion.geometry import Ned, moved, times
from companion.motion.profile import SpeedLimits

_CHORDS, _CHORD_M = 8, 0.25  # the least number of points on a blend, and their distance

Vector = npt.NDArray[np.float64]
"""(3,) or (n, 3) NED."""


class PathPoint(NamedTuple):
    """A point of a path.

    Attributes:
        position: in the mission's frame.
        direction: of flight, of length 1.
        curvature: how the direction changes, per metre.
    """

    position: Ned
    direction: Ned
    curvature: Ned


@dataclass(frozen=True, eq=False)
class Blend:
    """A rounded corner.

    Attributes:
        corner: where the two legs meet.
        before: direction of the first leg, of length 1.
        after: direction of the second leg, of length 1; neither equal nor opposite to `before`.
        reach_m: distance from the corner to where the blend leaves the first leg and joins the
            second.

    >>> north, east = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    >>> quarter = Blend(np.zeros(3), north, east, 1.0)
    >>> round(quarter.length_m, 2), quarter.position(0.0).tolist()
    (1.68, [-1.0, 0.0, 0.0])
    """

    corner: Vector
    before: Vector
    after: Vector
    reach_m: float

    @cached_property
    def turn_rad(self) -> float:
        """The angle between the legs."""
        chord, sum_ = self.after - self.before, self.after + self.before
        return 2 * math.atan2(float(np.linalg.norm(chord)), float(np.linalg.norm(sum_)))

    @cached_property
    def length_m(self) -> float:
        """The length of both clothoids."""
        along, aside = self._whole
        return float(2 * self.reach_m / (along + aside * math.tan(self.turn_rad / 2)))

    @property
    def depth_m(self) -> float:
        """The least distance between the blend and the corner."""
        _, aside = self._whole
        return self.length_m / 2 * aside / math.cos(self.turn_rad / 2)

    def position(self, along_m: npt.ArrayLike) -> Vector:
        """(..., 3) the points at distances (...) along the blend."""
        along_m = np.asarray(along_m, dtype=np.float64)
        parts = _clothoid(self.turn_rad, self._share(along_m))
        along, aside = (self.length_m / 2 * part[..., None] for part in parts)
        return np.where(
            (along_m <= self.length_m / 2)[..., None],
            self._begin + along * self.before + aside * self._aside,
            self._end - along * self.after + aside * self._aside_after,
        )

    def direction(self, along_m: npt.ArrayLike) -> Vector:
        """(..., 3) the directions of flight at distances (...) along the blend, of length 1."""
        turned = self._turned(np.asarray(along_m, dtype=np.float64))[..., None]
        return np.asarray(np.cos(turned) * self.before + np.sin(turned) * self._aside)

    def at(self, along_m: float) -> PathPoint:
        """The point at one distance along the blend; plain numbers are faster for one point."""
        half_m, turn_rad = self.length_m / 2, self.turn_rad
        is_before = along_m <= half_m
        share = (along_m if is_before else self.length_m - along_m) / half_m
        ahead_m, aside_m = (half_m * float(part) for part in _clothoid(turn_rad, share))
        first, second = self._clothoids
        begin, ahead, aside = first if is_before else second
        turned = turn_rad / 2 * share**2
        turned = turned if is_before else turn_rad - turned
        cos, sin = math.cos(turned), math.sin(turned)
        _, before, across = first
        return PathPoint(
            moved(moved(begin, ahead, ahead_m), aside, aside_m),
            moved(times(before, cos), across, sin),
            times(moved(times(across, cos), before, -sin), 2 * turn_rad / self.length_m * share),
        )

    def chords(self, from_m: float = 0.0) -> Vector:
        """(n, 3) points from a distance along the blend to its end; evenly spaced, n >= 2."""
        return self._outline[0] if from_m == 0.0 else self.position(self._evenly(from_m))

    def tangents(self) -> Vector:
        """(n, 3) the beginning, the points where the tangents at its `chords` meet, and the end.

        The curve lies between these legs and the chords.
        """
        points, directions = self._outline
        plane = np.stack([self.before, self._aside], axis=1)
        chords, directions_2d = np.diff(points, axis=0) @ plane, directions @ plane
        ahead_m = cross(chords, directions_2d[1:]) / cross(directions_2d[:-1], directions_2d[1:])
        meets = points[:-1] + ahead_m[:, None] * directions[:-1]
        return np.vstack([points[:1], meets, points[-1:]])

    def speed_mps(self, limits: SpeedLimits) -> float:
        """The greatest constant speed along the blend."""
        across_mps = math.sqrt(limits.acceleration_mps2 * self.length_m / (2 * self.turn_rad))
        jerk_mps = math.cbrt(limits.jerk_mps3 * self.length_m**2 / (4 * self.turn_rad))
        slowest_mps = min(limits.along(down).speed_mps for down in self._steepest())
        return min(across_mps, jerk_mps, slowest_mps)

    @cached_property
    def _outline(self) -> tuple[Vector, Vector]:
        """(n, 3) points along the blend, and the directions there."""
        along_m = self._evenly(0.0)
        return self.position(along_m), self.direction(along_m)

    def _evenly(self, from_m: float) -> npt.NDArray[np.float64]:
        count = _CHORDS + math.ceil((self.length_m - from_m) / _CHORD_M)
        return np.linspace(from_m, self.length_m, count)

    @cached_property
    def _whole(self) -> tuple[float, float]:
        """How far a clothoid of length 1 leads along its leg, and across."""
        along, aside = _clothoid(self.turn_rad, 1.0)
        return float(along), float(aside)

    @cached_property
    def _begin(self) -> Vector:
        """Where the blend leaves the first leg."""
        return self.corner - self.reach_m * self.before

    @cached_property
    def _end(self) -> Vector:
        """Where the blend joins the second leg."""
        return self.corner + self.reach_m * self.after

    @cached_property
    def _aside(self) -> Vector:
        """Unit vector across the first leg, towards the inside of the corner."""
        aside = self.after - math.cos(self.turn_rad) * self.before
        return np.asarray(aside / math.sin(self.turn_rad))

    @cached_property
    def _aside_after(self) -> Vector:
        """Unit vector across the second leg, towards the inside of the corner."""
        aside = math.cos(self.turn_rad) * self.after - self.before
        return np.asarray(aside / math.sin(self.turn_rad))

    @cached_property
    def _clothoids(self) -> tuple[tuple[Ned, Ned, Ned], tuple[Ned, Ned, Ned]]:
        """Each clothoid's straight end, the direction of its leg from there, and the inside."""
        first = ned_of(self._begin), ned_of(self.before), ned_of(self._aside)
        return first, (ned_of(self._end), ned_of(-self.after), ned_of(self._aside_after))

    def _share(self, along_m: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """The share of one clothoid that lies between these distances and its straight end."""
        return np.minimum(along_m, self.length_m - along_m) / (self.length_m / 2)

    def _turned(self, along_m: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """The angles between the first leg and the directions at these distances."""
        turned = self.turn_rad / 2 * self._share(along_m) ** 2
        return np.where(along_m <= self.length_m / 2, turned, self.turn_rad - turned)

    def _steepest(self) -> list[float]:
        """Vertical components (down) of the directions among which the steepest one is."""
        level, down = float(self.before[2]), float(self._aside[2])
        peak = math.atan2(down, level)  # the turn at which it descends most steeply
        inside = [
            sign * math.hypot(level, down)
            for sign, at in ((1.0, peak), (-1.0, peak + math.pi))
            if 0.0 < at < self.turn_rad
        ]
        return [level, float(self.after[2]), *inside]


def cross(a: Vector, b: Vector) -> Vector:
    """(n,) cross products of vectors (n, 2); positive if the second lies to the first's right."""
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


def ned_of(vector: Vector) -> Ned:
    """A position or a direction as plain numbers."""
    north, east, down = vector.tolist()
    return (north, east, down)


@overload
def _clothoid(turn_rad: float, share: float) -> tuple[float, float]: ...
@overload
def _clothoid(
    turn_rad: float, share: npt.NDArray[np.float64]
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]: ...
def _clothoid(turn_rad: float, share: Any) -> tuple[Any, Any]:
    """Points of a clothoid of length 1 that turns by half an angle: along its leg, and across."""
    scale = math.sqrt(turn_rad / math.pi)
    aside, along = fresnel(share * scale)
    return along / scale, aside / scale
