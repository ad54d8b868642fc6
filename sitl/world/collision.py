"""Collisions with walls, and with the ground by more than the legs.

Walls are the occupied cells of the true map, and low ones up to where they end; off the map counts
as a wall, unless it is open. The vehicle is a disc, its legs below it. Accuracy is that of the
map's distance field: about one cell. The flight physics knows contact of the legs alone, so a
vehicle that falls over has to be stopped: it would sink into the ground.

The upper end of a low wall is ground to a vehicle above it: a roof, on which it can stand. One that
stands there with a leg beyond the edge falls off it.
"""

from __future__ import annotations

import math

import numpy as np

from companion.geometry import Ned
from companion.motion.grid import OccupancyGrid
from sitl.flight.physics import LEG_M, FlightState

UPRIGHT = 0.5  # cosine of the tilt at which the body touches the ground beside the legs
FEET_M = 0.1 * math.sqrt(2)
"""From the vehicle's centre to its feet, over the ground."""


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

    def walls(self, position: Ned, ground_m: float) -> OccupancyGrid | None:
        """What a vehicle hits that comes too near to it; arguments as below.

        A roof that carries it is none, however far its legs give way.
        """
        return None if self.grid is None else self.grid.at(max(-position[2], ground_m))

    def update(self, position: Ned, ground_m: float = 0.0) -> bool:
        """Takes a position; true when a collision begins there.

        Args:
            position: of the vehicle.
            ground_m: the height of what carries it, which it does not hit.
        """
        walls = self.walls(position, ground_m)
        if walls is None:
            return False
        was_touching = self._is_touching
        self._is_touching = walls.is_within(position[:2], self._radius_m)
        has_begun = self._is_touching and not was_touching
        self.count += has_begun
        return has_begun


def ground_up_m(grid: OccupancyGrid | None, position: Ned, before_m: float) -> float:
    """Height above home of what carries a vehicle that is there: the ground, or a roof.

    Args:
        grid: the true map.
        position: of the vehicle.
        before_m: the same of a moment ago: legs give way on a roof, and it still is one.
    """
    if grid is None or grid.low is None:
        return 0.0
    row, col = grid.cell(position[:2])
    if not grid.contains(row, col):
        return 0.0
    top_m = float(grid.low.tops_m[row, col])
    sunk_m = LEG_M if top_m == before_m else 0.0
    return top_m if top_m <= sunk_m - position[2] else 0.0


def is_over_edge(grid: OccupancyGrid | None, state: FlightState, ground_m: float) -> bool:
    """True if a vehicle that touches a roof has a foot beyond its edge.

    Args:
        grid: the true map.
        state: of the vehicle.
        ground_m: the height of what carries it.
    """
    if grid is None or grid.low is None or ground_m <= 0 or not state.is_on_ground:
        return False
    north, east, _ = state.position
    angles = state.euler[2] + math.pi * (np.arange(4) / 2 + 0.25)
    feet = zip(north + FEET_M * np.cos(angles), east + FEET_M * np.sin(angles), strict=True)
    cells = [grid.cell(foot) for foot in feet]
    return any(not grid.contains(*cell) or grid.low.tops_m[cell] < ground_m for cell in cells)


def is_wreck(state: FlightState, ground_m: float = 0.0) -> bool:
    """True if the body touches the ground: fallen over, or hit harder than the legs can take.

    Args:
        state: of the vehicle.
        ground_m: how high the ground is.
    """
    _, x, y, _ = state.attitude
    is_upright = 1 - 2 * (x * x + y * y) > UPRIGHT
    down = state.position[2] + ground_m
    return down > LEG_M or (down > -LEG_M / 2 and not is_upright)
