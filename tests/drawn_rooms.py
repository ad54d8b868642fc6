"""Small maps as drawings, and places on them."""

from __future__ import annotations

import numpy as np

from companion.geometry import NorthEast
from companion.motion.grid import OccupancyGrid
from companion.motion.region import Disc
from companion.motion.routes import PlaceRegion

WIDE: list[NorthEast] = [(-9, -9), (-9, 99), (99, 99), (99, -9)]


def grid_of(*rows: str, cell_m: float = 1.0) -> OccupancyGrid:
    """A grid from a drawing, its last line southmost; # is occupied."""
    occupied = np.array([[cell == "#" for cell in row] for row in reversed(rows)])
    return OccupancyGrid(occupied, cell_m, (0.0, 0.0))


def at(
    north_m: float, east_m: float, radius_m: float = 0.4, is_exclusive: bool = True
) -> PlaceRegion:
    return PlaceRegion((north_m, east_m, -2.0), Disc(radius_m), is_exclusive)


ROOM = grid_of(
    "##########",
    "#........#",
    "#...##...#",
    "#...##...#",
    "#........#",
    "##########",
)
EMPTY = OccupancyGrid(np.zeros((80, 80), dtype=np.bool_), 0.1, (0.0, 0.0))
