"""Collisions of the vehicle with walls, and of its body with the ground.

1. Walls are the occupied cells of the true map, up to their upper end where they are low. Off the
   map counts as a wall, unless the map is open.
2. The vehicle is a disc with legs below it. The accuracy is that of the map's distance field: about
   one cell.
3. The flight physics knows only contacts of the legs. A vehicle that falls over has to be stopped
   here, or it would sink into the ground.
4. The upper end of a low wall is a roof, on which the vehicle can stand. With a leg beyond the
   edge, the vehicle falls off.
"""

from __future__ import annotations

import math

import numpy as np

from companion.geometry import Ned
from companion.motion.grid import OccupancyGrid
from sitl.flight.physics import LEG_M, FlightState

UPRIGHT = 0.5  # cosine of the tilt at which the body touches the ground beside the legs
FEET_M = 0.1 * math.sqrt(2)
"""Horizontal distance from the vehicle's centre to its feet."""


class CollisionCounter:
    """Counts the contacts of the vehicle with walls.

    Args:
        grid: the true map; None is a world without walls.
        radius_m: the radius of the vehicle.

    Attributes:
        grid: the true map; replaced when the map changes.
        count: collisions so far.
    """

    def __init__(self, grid: OccupancyGrid | None, radius_m: float) -> None:
        self.count = 0
        self._radius_m = radius_m
        self.grid = grid
        self._is_touching = False

    def walls(self, position: Ned, ground_m: float) -> OccupancyGrid | None:
        """The walls with which the vehicle can collide; arguments as in `update`.

        The roof that carries the vehicle is not among them, however far the legs are compressed.
        """
        return None if self.grid is None else self.grid.at(max(-position[2], ground_m))

    def update(self, position: Ned, ground_m: float = 0.0) -> bool:
        """Takes a position; returns whether a collision begins there.

        Args:
            position: the position of the vehicle.
            ground_m: height of what carries the vehicle, with which it does not collide.
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
    """Height above home of what carries a vehicle at this position: the ground, or a roof.

    Args:
        grid: the true map.
        position: the position of the vehicle.
        before_m: the last result; it keeps a vehicle on its roof while the legs are compressed.
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
    """Whether a vehicle that touches a roof has a foot beyond the edge.

    Args:
        grid: the true map.
        state: the state of the vehicle.
        ground_m: height of what carries it.
    """
    if grid is None or grid.low is None or ground_m <= 0 or not state.is_on_ground:
        return False
    north, east, _ = state.position
    angles = state.euler[2] + math.pi * (np.arange(4) / 2 + 0.25)
    feet = zip(north + FEET_M * np.cos(angles), east + FEET_M * np.sin(angles), strict=True)
    cells = [grid.cell(foot) for foot in feet]
    return any(not grid.contains(*cell) or grid.low.tops_m[cell] < ground_m for cell in cells)


def is_wreck(state: FlightState, ground_m: float = 0.0) -> bool:
    """Whether the body touches the ground: it has fallen over, or hit too hard for its legs.

    Args:
        state: the state of the vehicle.
        ground_m: height of the ground.
    """
    _, x, y, _ = state.attitude
    is_upright = 1 - 2 * (x * x + y * y) > UPRIGHT
    down = state.position[2] + ground_m
    return down > LEG_M or (down > -LEG_M / 2 and not is_upright)
