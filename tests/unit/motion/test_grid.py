"""The occupancy grid: indices, positions and what lies outside."""

from __future__ import annotations

import numpy as np
import pytest

from companion.motion.grid import OccupancyGrid

GRID = OccupancyGrid(np.eye(3, 4, dtype=np.bool_), 0.5, (-1.0, 2.0))


def test_rows_grow_north_and_columns_east() -> None:
    assert GRID.cell((-1.0, 2.0)) == (0, 0)
    assert GRID.cell((-0.4, 3.9)) == (1, 3)
    assert GRID.cell((-1.1, 1.9)) == (-1, -1)


def test_a_cell_holds_its_centre() -> None:
    for cell in np.ndindex(3, 4):
        assert GRID.cell(GRID.centre(*cell)) == cell


@pytest.mark.parametrize(
    ("cell", "is_on_grid"), [((0, 0), True), ((2, 3), True), ((3, 0), False), ((0, -1), False)]
)
def test_contains(cell: tuple[int, int], is_on_grid: bool) -> None:
    assert GRID.contains(*cell) is is_on_grid


def test_the_outside_is_occupied_up_to_the_rim() -> None:
    empty = OccupancyGrid(np.zeros((5, 5), dtype=np.bool_), 0.2, (0.0, 0.0))
    assert empty.clearance_m((0.13, 0.5)) == pytest.approx(0.13)
    assert empty.clearance_m((0.5, 0.5)) == pytest.approx(0.5)
    assert empty.clearance_m((-0.1, 0.5)) == 0.0
    assert empty.distance_m[0, 0] == 0.0  # its outer edges are on the rim
    assert empty.distance_m[2, 2] == pytest.approx(0.4)
