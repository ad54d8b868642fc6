"""Has the vehicle hit a wall?

Walls are the occupied cells of the true map and have no upper end; off the map counts as a wall.
The vehicle is a disc. Accuracy is that of the map's distance field: about one cell.
"""

from __future__ import annotations

from companion.geometry import Ned
from companion.motion.grid import OccupancyGrid

VEHICLE_RADIUS_M = 0.35


class CollisionWatch:
    """Counts how often the vehicle came to touch a wall.

    Args:
        grid: the true map; None is a world without walls.
    """

    def __init__(self, grid: OccupancyGrid | None) -> None:
        self.count = 0
        self._grid = grid
        self._is_touching = False

    def update(self, position: Ned) -> bool:
        """Take a position; true when a collision begins there."""
        if self._grid is None:
            return False
        was_touching = self._is_touching
        self._is_touching = self._grid.clearance_m(position[:2]) < VEHICLE_RADIUS_M
        has_begun = self._is_touching and not was_touching
        self.count += has_begun
        return has_begun
