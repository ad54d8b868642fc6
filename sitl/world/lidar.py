"""The lidar: distances to the nearest walls, all around the vehicle.

A level scanner in the vehicle's centre: 72 beams, 5 degrees apart, the first one straight ahead,
then clockwise. It turns with the heading; tilt is left out. It looks over walls that end below it;
off a map that is not open is a wall, as for collisions.

A beam is exact up to rounding, and hits a corner that it grazes: the faces between free and
occupied cells are straight lines along rows and columns, and every beam is cut with all of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from random import Random
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from companion.geometry import NorthEast
from companion.motion.grid import OccupancyGrid

BEAMS = 72
STEP_RAD = 2 * math.pi / BEAMS
Floats = npt.NDArray[np.float64]
_AHEAD: Floats = np.array([math.cos(i * STEP_RAD) for i in range(BEAMS)])
_RIGHT: Floats = np.array([math.sin(i * STEP_RAD) for i in range(BEAMS)])
_BEAMS, _BEAMS_TURNED = np.array((_AHEAD, _RIGHT)), np.array((-_RIGHT, _AHEAD))
"""(2, BEAMS) north and east of each beam while the vehicle looks north, and while it looks east."""

_NORTH, _EAST = 0, 1


@dataclass(frozen=True, slots=True)
class LidarSpec:
    """Range and noise of the scanner.

    Attributes:
        component: its MAVLink component id. 196 is MAV_COMP_ID_OBSTACLE_AVOIDANCE, the one id of
            common.xml for who reports obstacles, and no autopilot uses it for anything else.
        range_m: farther walls are not seen.
        noise_m: standard deviation of each distance.
    """

    component: int = 196
    range_m: float = 12.0
    noise_m: float = 0.0


class WallFaces(NamedTuple):
    """The n borders between free cells and walls, in cells.

    Attributes:
        ends: (3, n) where on the axis that a border lies across, and from where to where along
            the other one.
        axes: (3, n) the axis of each of these, 0 north or 1 east.
        side: (n,) on which the wall is, 1 or -1.
    """

    ends: Floats
    axes: npt.NDArray[np.int_]
    side: Floats


class Lidar:
    """Scans the true map.

    Args:
        spec: range and noise.
        grid: the true map; None is a world without walls.
        random: of the noise.
    """

    def __init__(self, spec: LidarSpec, grid: OccupancyGrid | None, random: Random) -> None:
        self.spec = spec
        self._random = random
        self.set_map(grid)

    def set_map(self, grid: OccupancyGrid | None) -> None:
        """The true map from now on."""
        self._grid = grid
        self._faces: dict[int, WallFaces] = {}

    def scan(self, position: NorthEast, yaw_rad: float, up_m: float = 0.0) -> Floats:
        """(BEAMS,) distance along each beam, metres; inf where nothing is within range.

        Args:
            position: of the vehicle.
            yaw_rad: its heading.
            up_m: its altitude above home.
        """
        if self._grid is None:
            return np.full(BEAMS, math.inf)
        layer = self._grid.layer(up_m)
        grid = self._grid.in_layer(layer)
        if layer not in self._faces:
            self._faces[layer] = _faces_of(grid)
        row, column = grid.cell(position)
        is_on_map = grid.contains(row, column)
        if grid.occupied[row, column] if is_on_map else not grid.is_open:
            return np.zeros(BEAMS)
        start = (np.array(position) - grid.origin) / grid.cell_m
        beams = math.cos(yaw_rad) * _BEAMS + math.sin(yaw_rad) * _BEAMS_TURNED
        far = self.spec.range_m / grid.cell_m
        lengths = _lengths_to_walls(self._faces[layer], start, beams, far)
        distances_m = np.where(lengths <= far, grid.cell_m * lengths, math.inf)
        if self.spec.noise_m > 0:
            noise = [self._random.gauss(0.0, self.spec.noise_m) for _ in range(BEAMS)]
            distances_m = np.maximum(0.0, distances_m + noise)
        return distances_m


def _faces_of(grid: OccupancyGrid) -> WallFaces:
    """All borders of a map."""
    walls = np.pad(grid.occupied, 1, constant_values=not grid.is_open)
    north, east = _faces(walls), _faces(walls.T)
    across = np.repeat((_NORTH, _EAST), (north.shape[1], east.shape[1]))
    *ends, side = np.hstack((north, east))
    return WallFaces(np.array(ends), np.array((across, 1 - across, 1 - across)), side)


def _faces(walls: npt.NDArray[np.bool_]) -> Floats:
    """Ends and side, (4, n), of the borders of free cells and walls, joined where they touch.

    Args:
        walls: (lines + 2, cells + 2), with a rim of what lies off the map; the lines follow each
            other along the axis that the borders lie across.
    """
    found = []
    steps = np.diff(walls[:, 1:-1].astype(np.int8), axis=0)
    for side in (1, -1):
        turns = np.diff((steps == side).astype(np.int8), axis=1, prepend=0, append=0)
        line, begin = np.nonzero(turns == 1)
        _, end = np.nonzero(turns == -1)
        found.append((line, begin, end, np.full(len(line), side)))
    return np.concatenate(found, axis=1, dtype=np.float64)


def _lengths_to_walls(faces: WallFaces, start: Floats, beams: Floats, far: float) -> Floats:
    """The length of each beam up to its first face, inf without one; everything in cells.

    Args:
        faces: of the map.
        start: (2,) north and east.
        beams: (2, BEAMS) directions.
        far: faces farther away may be left out.
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
    is_hit = (lengths >= 0) & (at >= begin) & (at <= end)
    return np.asarray(np.where(is_hit, lengths, math.inf).min(axis=0, initial=math.inf))
