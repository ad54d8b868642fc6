"""Collisions with walls, and with the ground by more than the legs.

Walls are the occupied cells of the true map, and low ones up to where they end; off the map counts
as a wall, unless it is open. The vehicle is a disc, its legs below it. Accuracy is that of the
map's distance field: about one cell. The flight physics knows contact of the legs alone, so a
vehicle that falls over has to be stopped: it would sink into the ground.
"""

from __future__ import annotations

from companion.geometry import Ned
from companion.motion.grid import OccupancyGrid
from sitl.flight.physics import LEG_M, FlightState

UPRIGHT = 0.5  # cosine of the tilt at which the body touches the ground beside the legs


class CollisionCounter:
    """Counts the contacts of the vehicle with walls.

    Args:
        grid: the true map; None is a world without walls.
        radius_m: of the vehicle.

    Attributes:
        grid: may be replaced when the map changes.
        count: of collisions so far.
    """

    def __init__(self, grid: OccupancyGrid | None, radius_m: float) -> None:
        self.count = 0
        self._radius_m = radius_m
        self.grid = grid
        self._is_touching = False

    def update(self, position: Ned) -> bool:
        """Takes a position; true when a collision begins there."""
        if self.grid is None:
            return False
        was_touching = self._is_touching
        walls = self.grid.at(-position[2] - LEG_M)
        self._is_touching = walls.clearance_m(position[:2]) < self._radius_m
        has_begun = self._is_touching and not was_touching
        self.count += has_begun
        return has_begun


def is_wreck(state: FlightState) -> bool:
    """True if the body touches the ground: fallen over, or hit harder than the legs can take."""
    _, x, y, _ = state.attitude
    is_upright = 1 - 2 * (x * x + y * y) > UPRIGHT
    down = state.position[2]
    return down > LEG_M or (down > -LEG_M / 2 and not is_upright)
