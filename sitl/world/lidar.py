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
            self._row_faces, self._column_faces = _faces(walls), _faces(walls.T)

    def scan(self, position: NorthEast, yaw_rad: float) -> Floats:
        """(BEAMS,) distance along each beam, metres; inf where nothing is within range."""
        grid = self._grid
        if grid is None:
            return np.full(BEAMS, math.inf)
        row, column = grid.cell(position)
        if not grid.contains(row, column) or grid.occupied[row, column]:
            return np.zeros(BEAMS)
        north = (position[0] - grid.origin[0]) / grid.cell_m
        east = (position[1] - grid.origin[1]) / grid.cell_m
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        d_north, d_east = c * _AHEAD - s * _RIGHT, s * _AHEAD + c * _RIGHT
        far = self.spec.range_m / grid.cell_m
        way = np.minimum(
            _hits(self._row_faces, far, north, east, d_north, d_east),
            _hits(self._column_faces, far, east, north, d_east, d_north),
        )
        distances_m = np.where(way <= far, grid.cell_m * way, math.inf)
        if self.spec.noise_m > 0:
            noise = [self._random.gauss(0.0, self.spec.noise_m) for _ in range(BEAMS)]
            distances_m = np.maximum(0.0, distances_m + noise)
        return distances_m


def _faces(walls: npt.NDArray[np.bool_]) -> Floats:
    """The borders between a free row and a wall, joined where they touch.

    Args:
        walls: (rows + 2, columns + 2), with a rim of walls.

    Returns:
        (n, 4) where each lies, begins and ends, in cells, and on which side its wall is: 1 or -1.
    """
    inner = walls[:, 1:-1].astype(np.int8)
    return np.concatenate([_joined(np.diff(inner, axis=0) == side, side) for side in (1, -1)])


def _joined(is_border: npt.NDArray[np.bool_], side: int) -> Floats:
    turns = np.diff(is_border.astype(np.int8), axis=1, prepend=0, append=0)
    line, begin = np.nonzero(turns == 1)
    _, end = np.nonzero(turns == -1)
    return np.column_stack((line, begin, end, np.full(len(line), side))).astype(np.float64)


def _hits(
    faces: Floats, far: float, across: float, along: float, d_across: Floats, d_along: Floats
) -> Floats:
    """The way of each beam to its first face, inf without one; everything in cells.

    Args:
        faces: (n, 4) of one axis.
        far: those farther away may be left out.
        across: start, over the lines of the faces.
        along: start, along the lines.
        d_across: (BEAMS,) direction over the lines.
        d_along: (BEAMS,) direction along the lines.
    """
    line, begin, end, side = faces.T
    depth = (line - across) * side
    is_seen = (depth >= 0) & (depth <= far) & (begin <= along + far) & (end >= along - far)
    line, begin, end = faces[is_seen].T[:3, :, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        way = (line - across) / d_across
        at = along + way * d_along
        is_hit = (way >= 0) & (at >= begin) & (at <= end)
    return np.min(way, axis=0, initial=math.inf, where=is_hit)  # type: ignore[no-any-return]
