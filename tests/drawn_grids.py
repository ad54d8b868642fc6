"""Grids that properties of motion draw, and distances on them by brute force."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from hypothesis import strategies as st

from companion.geometry import NorthEast
from companion.motion.grid import OccupancyGrid

WIDE: list[NorthEast] = [(-99, -99), (-99, 99), (99, 99), (99, -99)]
Array = npt.NDArray[np.floating[Any]]


@st.composite
def grids(draw: st.DrawFn, edge: int = 16, boxes: int = 5) -> OccupancyGrid:
    """Rooms with boxes in them."""
    rows, cols = draw(st.integers(6, edge)), draw(st.integers(6, edge))
    occupied = np.zeros((rows, cols), dtype=np.bool_)
    for _ in range(draw(st.integers(0, boxes))):
        row, col = draw(st.integers(0, rows - 1)), draw(st.integers(0, cols - 1))
        height, width = draw(st.integers(1, 6)), draw(st.integers(1, 6))
        occupied[row : row + height, col : col + width] = True
    origin = (draw(st.sampled_from([0.0, -2.0, 0.37])), draw(st.sampled_from([0.0, -1.3])))
    return OccupancyGrid(occupied, draw(st.sampled_from([0.1, 0.25, 1.0])), origin)


def draw_position(data: st.DataObject, grid: OccupancyGrid, cells: list[list[int]]) -> NorthEast:
    """A position inside one of some cells."""
    row, col = data.draw(st.sampled_from(cells))
    inside = st.floats(0.02, 0.98)
    return (
        grid.origin[0] + (row + data.draw(inside)) * grid.cell_m,
        grid.origin[1] + (col + data.draw(inside)) * grid.cell_m,
    )


def brute_force_distance(grid: OccupancyGrid) -> Array:
    """Least gap between each cell and an occupied one, or the rim, edge to edge."""
    occupied = np.argwhere(np.pad(grid.occupied, 1, constant_values=True)) - 1
    cells = np.argwhere(np.ones_like(grid.occupied))
    gaps = np.maximum(np.abs(cells[:, None] - occupied[None]) - 1, 0)
    gaps[np.all(cells[:, None] == occupied[None], axis=2)] = 0
    distance = np.linalg.norm(gaps, axis=2).min(axis=1)
    return np.asarray(distance.reshape(grid.occupied.shape) * grid.cell_m)


def distance_to_leg(a: Array, b: Array, point: Array) -> float:
    leg = b - a
    share = float(np.clip((point - a) @ leg / max(float(leg @ leg), 1e-12), 0.0, 1.0))
    return float(np.linalg.norm(a + share * leg - point))
