"""How far is the nearest wall, all around the vehicle?

A level scanner in the vehicle's centre: 72 beams, 5 degrees apart, the first one straight ahead,
then clockwise. It turns with the heading; tilt is left out. Walls have no upper end, and off the
map is a wall, as for collisions.

A beam is exact up to rounding: where the distance field says that nothing is near, it leaps;
elsewhere it goes from cell to cell (Amanatides and Woo, "A fast voxel traversal algorithm", 1987),
so that a grazed corner is not missed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from random import Random

from companion.geometry import NorthEast
from companion.motion.grid import OccupancyGrid

BEAMS = 72
STEP_RAD = 2 * math.pi / BEAMS


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
        # From any point of a cell to any point of an obstacle: centre to centre, less half a
        # diagonal at either end. Lists, because numpy is slow for single cells.
        self._free: list[list[float]] = []
        if grid is not None:
            leaps = grid.distance_m / grid.cell_m - math.sqrt(2)
            leaps[grid.occupied] = -math.inf
            self._free = leaps.tolist()

    def scan(self, position: NorthEast, yaw_rad: float) -> list[float]:
        """Distance along each beam, metres; inf where nothing is within range."""
        if self._grid is None:
            return [math.inf] * BEAMS
        cell_m, (north_m, east_m) = self._grid.cell_m, self._grid.origin
        y, x = (position[0] - north_m) / cell_m, (position[1] - east_m) / cell_m
        far = self.spec.range_m / cell_m
        distances_m = [
            cast(self._free, y, x, yaw_rad + i * STEP_RAD, far) * cell_m for i in range(BEAMS)
        ]
        if self.spec.noise_m > 0:
            gauss, deviation = self._random.gauss, self.spec.noise_m
            return [max(0.0, d + gauss(0.0, deviation)) for d in distances_m]
        return distances_m


def cast(free: list[list[float]], y: float, x: float, angle_rad: float, far: float) -> float:
    """Where a beam hits; everything in cells.

    Args:
        free: how far one may go from anywhere in a cell without a hit; -inf is occupied.
        y: start, rows northward.
        x: start, columns eastward.
        angle_rad: clockwise from north.
        far: the beam's range.

    Returns:
        The way to the first occupied cell, or off the grid; inf beyond the range.
    """
    dy, dx = math.cos(angle_rad), math.sin(angle_rad)
    rows, cols = len(free), len(free[0])
    per_row = 1 / dy if dy else math.inf
    per_col = 1 / dx if dx else math.inf
    up, right = (1 if dy > 0 else 0), (1 if dx > 0 else 0)
    t = 0.0
    row, col = math.floor(y), math.floor(x)
    while t <= far:
        if not (0 <= row < rows and 0 <= col < cols):
            return t
        leap = free[row][col]
        if leap > 1.0:  # never beyond the first wall, and so never off the grid
            t += leap
            row, col = int(y + t * dy), int(x + t * dx)
            continue
        if leap == -math.inf:
            return t
        t_row = (row + up - y) * per_row if dy else math.inf
        t_col = (col + right - x) * per_col if dx else math.inf
        if t_row < t_col:
            t, row = t_row, row + 2 * up - 1
        else:
            t, col = t_col, col + 2 * right - 1
    return math.inf
