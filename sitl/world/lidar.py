"""How far is the nearest wall, all around the vehicle?

A level scanner in the vehicle's centre: 72 beams, 5 degrees apart, the first one straight ahead,
then clockwise. It turns with the heading; tilt is left out. Walls have no upper end, and off the
map is a wall, as for collisions.

A beam is exact up to rounding, and hits a corner that it grazes: the faces between free and
occupied cells are straight lines along rows and columns, and every beam is cut with all of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from random import Random

import numpy as np
import numpy.typing as npt

from companion.geometry import NorthEast
from companion.motion.grid import OccupancyGrid

BEAMS = 72
STEP_RAD = 2 * math.pi / BEAMS
_AHEAD = np.array([math.cos(i * STEP_RAD) for i in range(BEAMS)])
_RIGHT = np.array([math.sin(i * STEP_RAD) for i in range(BEAMS)])

_NORTH, _EAST = 0, 1

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class LidarSpec:
    """What the scanner can do.

    Attributes:
        component: its MAVLink component id. 196 is MAV_COMP_ID_OBSTACLE_AVOIDANCE, the one id of
            common.xml for who reports obstacles, and no autopilot uses it for anything else.
        range_m: farther walls are not seen.
        noise_m: standard deviation of each distance.
    """

    component: int = 196
    range_m: float = 12.0
    noise_m: float = 0.0


class Lidar:
    """Scans a grid.

    Args:
        spec: range and noise.
        grid: the true map; None is a world without walls.
        random: of the noise.
    """

    def __init__(self, spec: LidarSpec, grid: OccupancyGrid | None, random: Random) -> None:
        self.spec = spec
        self._random = random
        self.see(grid)

    def see(self, grid: OccupancyGrid | None) -> None:
        """The true map from now on."""
        self._grid = grid
        if grid is not None:
            walls = np.pad(grid.occupied, 1, constant_values=True)
            self._faces = np.concatenate((_faces(walls, _NORTH), _faces(walls.T, _EAST)))

    def scan(self, position: NorthEast, yaw_rad: float) -> Floats:
        """(BEAMS,) distance along each beam, metres; inf where nothing is within range."""
        grid = self._grid
        if grid is None:
            return np.full(BEAMS, math.inf)
        row, column = grid.cell(position)
        if not grid.contains(row, column) or grid.occupied[row, column]:
            return np.zeros(BEAMS)
        start = (np.array(position) - grid.origin) / grid.cell_m
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        beams = np.array((c * _AHEAD - s * _RIGHT, s * _AHEAD + c * _RIGHT))
        far = self.spec.range_m / grid.cell_m
        way = _hits(self._faces, start, beams, far)
        distances_m = np.where(way <= far, grid.cell_m * way, math.inf)
        if self.spec.noise_m > 0:
            noise = [self._random.gauss(0.0, self.spec.noise_m) for _ in range(BEAMS)]
            distances_m = np.maximum(0.0, distances_m + noise)
        return distances_m


def _faces(walls: npt.NDArray[np.bool_], axis: int) -> Floats:
    """The borders between a free line of cells and a wall, joined where they touch.

    Args:
        walls: (lines + 2, cells + 2), with a rim of walls.
        axis: that the lines follow each other along.

    Returns:
        (n, 5) the axis, where each lies, begins and ends, in cells, and on which side its wall
        is, 1 or -1.
    """
    found = []
    steps = np.diff(walls[:, 1:-1].astype(np.int8), axis=0)
    for side in (1, -1):
        turns = np.diff((steps == side).astype(np.int8), axis=1, prepend=0, append=0)
        line, begin = np.nonzero(turns == 1)
        _, end = np.nonzero(turns == -1)
        found += [(axis, *where, side) for where in zip(line, begin, end, strict=True)]
    return np.array(found, dtype=np.float64).reshape(-1, 5)


def _hits(faces: Floats, start: Floats, beams: Floats, far: float) -> Floats:
    """The way of each beam to its first face, inf without one; everything in cells.

    Args:
        faces: as from `_faces`.
        start: (2,) north and east.
        beams: (2, BEAMS) directions.
        far: faces farther away may be left out.
    """
    axis, line, begin, end, side = faces.T
    over = axis.astype(np.intp)
    across, along = start[over], start[1 - over]
    depth = (line - across) * side
    is_seen = (depth >= 0) & (depth <= far) & (begin <= along + far) & (end >= along - far)
    over, line, begin, end = over[is_seen], line[is_seen], begin[is_seen], end[is_seen]
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        way = (line - across[is_seen])[:, None] / beams[over]
        at = along[is_seen][:, None] + way * beams[1 - over]
        is_hit = (way >= 0) & (at >= begin[:, None]) & (at <= end[:, None])
    return np.min(way, axis=0, initial=math.inf, where=is_hit)  # type: ignore[no-any-return]
