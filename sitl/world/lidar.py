"""The lidar: distances to the nearest walls, or the ground, all around the vehicle.

The scanner is fixed to the centre of the vehicle. It has 72 beams, 5 degrees apart, from straight
ahead clockwise. They lie in one plane, which tilts with the vehicle: a beam meets the ground or a
roof, or passes over a wall that ends below it. As for collisions, off the map counts as a wall,
unless the map is open.

A beam is exact up to rounding, and also hits a corner that it only grazes: the faces between free
and occupied cells are straight lines along rows and columns, and each beam is intersected with all.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from random import Random
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from companion.geometry import NorthEast, body_plane
from companion.motion.grid import OccupancyGrid

BEAMS = 72
STEP_RAD = 2 * math.pi / BEAMS
Floats = npt.NDArray[np.float64]
_BEAMS: Floats = np.array(
    [(math.cos(i * STEP_RAD), math.sin(i * STEP_RAD)) for i in range(BEAMS)]
).T
"""(2, BEAMS) the forward and right components of each beam."""
_LEVEL, _LEAST_UP_M = 1e-12, 1e-3  # a beam with less slope meets no ground, at any height

_NORTH, _EAST = 0, 1


@dataclass(frozen=True, slots=True)
class LidarSpec:
    """Range and noise of the scanner.

    Attributes:
        component: its MAVLink component id. 196 is MAV_COMP_ID_OBSTACLE_AVOIDANCE, the only id in
            common.xml for a component that reports obstacles; no autopilot uses it otherwise.
        range_m: walls farther away are not seen.
        noise_m: standard deviation of each distance.
    """

    component: int = 196
    range_m: float = 12.0
    noise_m: float = 0.0


class WallFaces(NamedTuple):
    """The n borders between free cells and walls, in cells.

    Attributes:
        ends: (3, n) the coordinate across the border, then its start and end along the other axis.
        axes: (3, n) the axis of each of these, 0 north or 1 east.
        side: (n,) on which side the wall is, 1 or -1.
    """

    ends: Floats
    axes: npt.NDArray[np.int_]
    side: Floats


class Lidar:
    """Scans the true map.

    Args:
        spec: range and noise.
        grid: the true map; None is a world without walls.
        random: source of the noise.
    """

    def __init__(self, spec: LidarSpec, grid: OccupancyGrid | None, random: Random) -> None:
        self.spec = spec
        self._random = random
        self.set_map(grid)

    def set_map(self, grid: OccupancyGrid | None) -> None:
        """Replaces the true map."""
        self._grid = grid
        self._faces: dict[int, WallFaces] = {}

    def scan(
        self,
        position: NorthEast,
        yaw_rad: float,
        up_m: float = 0.0,
        tilt_rad: tuple[float, float] = (0.0, 0.0),
    ) -> Floats:
        """(BEAMS,) distance along each beam, metres; inf where nothing is within range.

        Args:
            position: the position of the vehicle.
            yaw_rad: its heading.
            up_m: height of the scanner above home.
            tilt_rad: roll and pitch of the vehicle.
        """
        beams = np.array(body_plane(*tilt_rad, yaw_rad)).T @ _BEAMS
        distances_m: Floats = max(up_m, _LEAST_UP_M) / np.maximum(beams[2], _LEVEL)  # to the ground
        if self._grid is not None:
            walls_m = self._to_walls(self._grid, position, up_m, beams)
            distances_m = np.minimum(distances_m, walls_m)
        distances_m[distances_m > self.spec.range_m] = math.inf
        if self.spec.noise_m > 0:
            noise = [self._random.gauss(0.0, self.spec.noise_m) for _ in range(BEAMS)]
            distances_m = np.maximum(0.0, distances_m + noise)
        return distances_m

    def _to_walls(
        self, world: OccupancyGrid, position: NorthEast, up_m: float, beams: Floats
    ) -> Floats:
        """(BEAMS,) distance along each beam to a wall or a roof, inf without one.

        Between two heights at which low walls end, all walls are treated as infinitely high. A beam
        crosses one such layer after the other, and meets a roof where it enters a wall from above.
        """
        row, column = world.cell(position)
        own = world.layer(up_m)
        occupied = world.in_layer(own).occupied
        if occupied[row, column] if world.contains(row, column) else not world.is_open:
            return np.zeros(BEAMS)
        cell_m, flat = world.cell_m, beams[:2]
        far, start = self.spec.range_m / cell_m, (np.array(position) - world.origin) / cell_m
        if world.low is None:
            return cell_m * _lengths_to_walls(self._faces_in(own), start, flat, far)
        down = np.where(np.abs(beams[2]) < _LEVEL, -_LEVEL, beams[2])
        found, ends_m = np.full(BEAMS, math.inf), (-math.inf, *world.low.heights_m, math.inf)
        least_m, most_m = (up_m - self.spec.range_m * d for d in (down.max(), down.min()))
        for layer in range(world.layer(least_m), world.layer(most_m) + 1):
            cuts = [(up_m - end_m) / cell_m / down for end_m in ends_m[layer : layer + 2]]
            enters, leaves = np.maximum(np.minimum(*cuts), 0.0), np.maximum(*cuts)
            met = _lengths_to_walls(self._faces_in(layer), start, flat, far, enters)
            is_on_roof = (layer < own) & (enters <= far)
            at = start[:, None] + flat * np.where(is_on_roof, enters, 0.0)
            is_on_roof &= _are_walls(world.in_layer(layer), at)
            met = np.where(is_on_roof, enters, met)
            found = np.minimum(found, np.where(met <= leaves, met, math.inf))
        return cell_m * found

    def _faces_in(self, layer: int) -> WallFaces:
        if layer not in self._faces:
            assert self._grid is not None
            self._faces[layer] = _faces_of(self._grid.in_layer(layer))
        return self._faces[layer]


def _are_walls(grid: OccupancyGrid, points: Floats) -> npt.NDArray[np.bool_]:
    """Whether each of some points (2, n), in cells, lies in an occupied cell of a map."""
    cells = np.floor(points).astype(np.intp)
    shape = np.array(grid.occupied.shape)[:, None]
    row, column = np.clip(cells, 0, shape - 1)
    is_on_map = ((cells >= 0) & (cells < shape)).all(axis=0)
    return np.asarray(grid.occupied[row, column] & is_on_map)


def _faces_of(grid: OccupancyGrid) -> WallFaces:
    """All borders of a map."""
    walls = np.pad(grid.occupied, 1, constant_values=not grid.is_open)
    north, east = _faces(walls), _faces(walls.T)
    across = np.repeat((_NORTH, _EAST), (north.shape[1], east.shape[1]))
    *ends, side = np.hstack((north, east))
    return WallFaces(np.array(ends), np.array((across, 1 - across, 1 - across)), side)


def _faces(walls: npt.NDArray[np.bool_]) -> Floats:
    """Ends and side, (4, n), of the borders between free cells and walls; adjacent ones are joined.

    Args:
        walls: (lines + 2, cells + 2), with a rim for what is off the map; lines are numbered along
            the axis across the borders.
    """
    found = []
    steps = np.diff(walls[:, 1:-1].astype(np.int8), axis=0)
    for side in (1, -1):
        turns = np.diff((steps == side).astype(np.int8), axis=1, prepend=0, append=0)
        line, begin = np.nonzero(turns == 1)
        _, end = np.nonzero(turns == -1)
        found.append((line, begin, end, np.full(len(line), side)))
    return np.concatenate(found, axis=1, dtype=np.float64)


def _lengths_to_walls(
    faces: WallFaces, start: Floats, beams: Floats, far: float, nearest: Floats | float = 0.0
) -> Floats:
    """The length of each beam up to its first face, inf without one; everything in cells.

    Args:
        faces: the faces of the map.
        start: (2,) north and east.
        beams: (2, BEAMS) horizontal parts of the directions, shorter for steeper beams.
        far: faces farther away may be left out.
        nearest: the length at which each beam begins.
    """
    offsets = faces.ends - start[faces.axes]
    away, begin, end = offsets
    depth = away * faces.side
    is_seen = (depth >= 0) & (depth <= far) & (begin <= far) & (end >= -far)
    away, begin, end = offsets[:, is_seen, None]
    axis = faces.axes[0, is_seen]
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        lengths = away * (1 / beams)[axis]
        at = lengths * beams[::-1][axis]
    is_hit = (lengths >= nearest) & (at >= begin) & (at <= end)
    return np.asarray(np.where(is_hit, lengths, math.inf).min(axis=0, initial=math.inf))
