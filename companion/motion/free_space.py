"""Which cells are free, which legs keep clear, and by which cell does a route begin?

A cell is free if the next obstacle is at least the clearance away and the fence holds all of the
cell. A route begins in a free cell or near one: where the vehicle has drifted, or something has
come near it. Points are in cells (`sight.py`), positions in metres.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from companion.geometry import NorthEast
from companion.motion.grid import OccupancyGrid
from companion.motion.moves import Cell
from companion.motion.regions import Regions
from companion.motion.sight import Points, Sight

ENTRY_M = 1.0  # how far from the nearest free cell a route may begin (tracking error)

_EDGE = 1e-6  # cells; nearer to the edge of a cell a leg might touch the next one
_MOST_VIEWS = 256


class _View(NamedTuple):
    """The free cells that a leg leads to from a start.

    Attributes:
        is_free: the start has the clearance; if not, legs out of there keep clear of walls alone.
        cells: (n, 2) nearest first.
    """

    is_free: bool
    cells: npt.NDArray[np.int_]


class FreeSpace:
    """What is free on one map.

    Attributes:
        grid: the map.
        free: (rows, cols) bool.

    Args:
        grid: the map.
        is_inside: (rows, cols) cells that the fence holds.
        clearance_m: least distance from a free cell's centre to an occupied cell's centre.
    """

    def __init__(
        self, grid: OccupancyGrid, is_inside: npt.NDArray[np.bool_], clearance_m: float
    ) -> None:
        self.grid = grid
        self.free: npt.NDArray[np.bool_] = (grid.distance_m >= clearance_m) & is_inside
        self._is_inside = is_inside
        self._clearance_m = clearance_m
        self._free_sight = Sight(self.free)
        self._open_sight = Sight(~grid.occupied)
        self._parts = ndimage.label(self.free)[0]
        self._views: dict[NorthEast, _View] = {}

    def point(self, positions: npt.ArrayLike) -> Points:
        """Positions, given by north, east and perhaps down, in units of cells."""
        plane = np.asarray(positions, dtype=np.float64)[..., :2]
        return np.asarray((plane - self.grid.origin) / self.grid.cell_m)

    def is_free(self, cell: Cell) -> bool:
        """Whether a cell is free; one off the map is not."""
        return self.grid.contains(*cell) and bool(self.free[cell])

    def is_clear(self, a: Points, b: Points) -> npt.NDArray[np.bool_]:
        """(...) whether the legs from a to b (..., 2) cross free cells only."""
        return self._free_sight.is_clear(a, b)

    def may_be_clear(self, a: Points, b: Points) -> npt.NDArray[np.bool_]:
        """A quick look at many legs: False only for those that are not clear."""
        return self._free_sight.may_be_clear(a, b)

    def keeps_away(self, a: Points, b: Points) -> bool:
        """Whether a leg comes no closer to an obstacle than the clearance and its start, by a cell.

        It leaves the fence only if it begins outside.
        """
        way = np.linspace(a, b, 2 + int(2 * math.dist(a, b)))
        cells = np.clip(np.floor(way).astype(int), 0, np.array(self.free.shape) - 1)
        away_m = self.grid.distance_m[cells[:, 0], cells[:, 1]]
        is_inside = self._is_inside[cells[:, 0], cells[:, 1]]
        least_m = min(away_m[0], self._clearance_m) - self.grid.cell_m
        is_kept = away_m.min() >= least_m and (is_inside.all() or not is_inside[0])
        return bool(is_kept and self._open_sight.is_clear(a, b))

    def is_connected(self, start: NorthEast, goal: Cell) -> bool:
        """Whether free cells lead from near a start to a cell."""
        if not self.is_free(goal):
            return False
        return bool(np.any(self._parts[self._near(self.grid.cell(start))] == self._parts[goal]))

    def entry(
        self, start: NorthEast, others: Regions, cost: npt.NDArray[np.float64]
    ) -> Cell | None:
        """The nearest cell to which a leg leads and from which there is a way.

        Args:
            start: where the route begins.
            others: regions that the leg may not enter.
            cost: (rows, cols) of the ways; inf where there is none.
        """
        own_cell, point = self.grid.cell(start), self.point(start)
        if self._is_plain(point, own_cell, others) and math.isfinite(cost[own_cell]):
            return own_cell
        view = self._view(start, own_cell)
        cells = view.cells[np.isfinite(cost[view.cells[:, 0], view.cells[:, 1]])]
        near = others.near(point, self._reach + 1)
        if near.names:
            cells = cells[~near.are_entered(point, cells.astype(np.float64) + 0.5)]
        if not len(cells):
            return None
        entry = cells[0]
        if not view.is_free:
            entry = next((cell for cell in cells if self.keeps_away(point, cell + 0.5)), entry)
        row, col = entry.tolist()
        return row, col

    @property
    def _reach(self) -> float:
        """The farthest entry, in cells."""
        return ENTRY_M / self.grid.cell_m

    def _view(self, start: NorthEast, own_cell: Cell) -> _View:
        """What is seen from a start; kept, since each place is a start on the way to all others."""
        if start not in self._views:
            point = self.point(start)
            is_free = bool(self._free_sight.is_clear(point, point))
            sight = self._free_sight if is_free else self._open_sight
            near = self._near(own_cell)
            cells = np.argwhere(self.free[near]) + [axis.start for axis in near]
            away = np.linalg.norm(cells - np.array(own_cell), axis=1)
            usable = (away <= self._reach) & sight.is_clear(point, cells + 0.5)
            if len(self._views) >= _MOST_VIEWS:
                self._views.clear()
            nearest = np.argsort(away[usable], kind="stable")
            self._views[start] = _View(is_free, cells[usable][nearest])
        return self._views[start]

    def _near(self, cell: Cell) -> tuple[slice, slice]:
        """The cells within ENTRY_M of one along each axis."""
        row, col = (
            slice(max(math.floor(x - self._reach), 0), max(math.ceil(x + self._reach) + 1, 0))
            for x in cell
        )
        return row, col

    def _is_plain(self, point: Points, cell: Cell, others: Regions) -> bool:
        """Whether a start is well inside a free cell, and at no border of a region.

        Its leg to the centre of the cell is then clear, and enters no region that it was not in.
        Most starts are plain, and the test is quick.
        """
        if not self.is_free(cell):
            return False
        row, col = point.tolist()
        if not (_EDGE < row - cell[0] < 1 - _EDGE and _EDGE < col - cell[1] < 1 - _EDGE):
            return False
        away = others.away(point)
        return not np.any((away >= -_EDGE) & (away <= 1))
