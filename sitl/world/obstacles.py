"""The true map: the map file plus the obstacles that are present.

A cell that an obstacle touches is occupied. The grid and its distance field are recomputed only
when an obstacle appears or disappears.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from companion.geometry import NorthEast
from companion.motion.grid import OccupancyGrid


@dataclass(frozen=True, slots=True)
class Obstacle:
    """All points within `radius_m` of a box; for a circle, the box is a single point.

    Attributes:
        south_west: corner of the box.
        north_east: the opposite corner.
    """

    name: str
    south_west: NorthEast
    north_east: NorthEast
    radius_m: float
    is_present: bool

    @property
    def corners(self) -> tuple[NorthEast, NorthEast]:
        """The south-western and north-eastern corners of its bounding box."""
        (south, west), (north, east), r = self.south_west, self.north_east, self.radius_m
        return (south - r, west - r), (north + r, east + r)

    def distance_m(self, point: NorthEast) -> float:
        """The distance of a point from the obstacle in metres; 0 inside.

        >>> Obstacle("crate", (1.0, 1.0), (1.0, 1.0), 0.5, True).distance_m((1.0, 3.0))
        1.5
        """
        gaps = (
            max(low - x, x - high, 0.0)
            for low, x, high in zip(self.south_west, point, self.north_east, strict=True)
        )
        return max(math.hypot(*gaps) - self.radius_m, 0.0)


class TrueMap:
    """The walls and the present obstacles.

    Args:
        walls: the grid of the map file.
        obstacles: all obstacles that the scenario names, present or not.

    Attributes:
        grid: the map with the obstacles that are present now.
    """

    def __init__(self, walls: OccupancyGrid | None, obstacles: Iterable[Obstacle]) -> None:
        self._walls = walls
        self._obstacles = {obstacle.name: obstacle for obstacle in obstacles}
        self._present = {name for name, o in self._obstacles.items() if o.is_present}
        self.grid = self._draw()

    def place(self, name: str, is_present: bool) -> bool:
        """Adds or removes an obstacle; returns whether this has changed the grid."""
        if (name in self._present) == is_present:
            return False
        (self._present.add if is_present else self._present.discard)(name)
        self.grid = self._draw()
        return True

    def distance_m(self, name: str, point: NorthEast) -> float:
        """Distance of a point from an obstacle in metres, present or not."""
        return self._obstacles[name].distance_m(point)

    def _draw(self) -> OccupancyGrid | None:
        walls = self._walls
        if walls is None or not self._present:
            return walls
        occupied = walls.occupied.copy()
        for name in self._present:
            occupied |= _touched(self._obstacles[name], walls)
        return walls.with_occupied(occupied)


def _touched(obstacle: Obstacle, grid: OccupancyGrid) -> npt.NDArray[np.bool_]:
    """The cells that contain a point of the obstacle, by the gaps between square and box."""
    gaps = []
    for axis in (0, 1):
        low = grid.origin[axis] + np.arange(grid.occupied.shape[axis]) * grid.cell_m
        gap = np.maximum(
            obstacle.south_west[axis] - (low + grid.cell_m), low - obstacle.north_east[axis]
        )
        gaps.append(np.maximum(gap, 0.0))
    touched = np.hypot(gaps[0][:, None], gaps[1][None, :]) <= obstacle.radius_m
    return np.asarray(touched, dtype=np.bool_)
