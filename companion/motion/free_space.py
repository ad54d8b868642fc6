"""Free space: which cells are free, which legs keep clear, and where a route begins.

1. A cell is free if all of it is at least the clearance away from the next obstacle, and inside the
   fence (`clearance_level.py`). A keep-out zone is an obstacle.
2. A route begins in a free cell, or near one if the vehicle has drifted or something has come near.
3. Out of a zone, the first leg leads straight to the nearest free cell, and comes no nearer to
   walls.

Points are in cells (`line_of_sight.py`), positions in metres.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from companion.geometry import NorthEast
from companion.motion.grid import OccupancyGrid
from companion.motion.grid_graph import Cell
from companion.motion.line_of_sight import LineOfSight, Points
from companion.motion.regions import Regions

ENTRY_M = 1.0  # greatest distance from a route's start to the nearest free cell (tracking error)

_ENTRY_CELLS = 1.5  # and at least so many cells: to those around its own cell
_BORDER = 1e-6  # cells; a leg nearer to the border of a cell might touch the next cell
_MAX_VIEWS = 256  # that are cached
_BATCH = 2000  # cells of each connected part that are tested together, for a start in a zone


class _View(NamedTuple):
    """The free cells within reach of a start to which a straight leg leads.

    Attributes:
        is_free: whether the start has the clearance; if not, legs from it only keep clear of walls.
        cells: (n, 2), the nearest first.
        reach: the greatest distance of these cells, in cells.
    """

    is_free: bool
    cells: npt.NDArray[np.int_]
    reach: float


def points_of(grid: OccupancyGrid, positions: npt.ArrayLike) -> Points:
    """Positions (..., 2 or 3) in metres, converted to cells."""
    plane = np.asarray(positions, dtype=np.float64)[..., :2]
    return np.asarray((plane - grid.origin) / grid.cell_m)


class FreeSpace:
    """The free cells of one map.

    Attributes:
        grid: the map.
        free: (rows, cols) bool.

    Args:
        grid: the map, on which zones are occupied.
        free: see above.
        is_inside: (rows, cols) cells inside the fence.
        clearance_m: the clearance of free cells, except near some places.
        walls: (rows, cols) the occupied cells that are solid, and not only zones.
    """

    def __init__(
        self,
        grid: OccupancyGrid,
        free: npt.NDArray[np.bool_],
        is_inside: npt.NDArray[np.bool_],
        clearance_m: float,
        walls: npt.NDArray[np.bool_],
    ) -> None:
        self.grid = grid
        self._walls = walls
        self.free = free
        self._is_inside = is_inside
        self._clearance_m = clearance_m
        self._free_sight = LineOfSight(free)
        self._views: dict[NorthEast, _View] = {}

    @cached_property
    def _open_sight(self) -> LineOfSight:
        return LineOfSight(~self.grid.occupied)

    @cached_property
    def _sight_between_walls(self) -> LineOfSight:
        return LineOfSight(~self._walls)

    @cached_property
    def _walls_alone(self) -> OccupancyGrid:
        return self.grid.with_occupied(self._walls)

    def _sight_away_from_walls(self, cell: Cell) -> LineOfSight:
        """Lines of sight over cells as far from walls as this one, or the clearance, less one."""
        away_m = self._walls_alone.distance_m
        least_m = min(float(away_m[cell]), self._clearance_m) - self.grid.cell_m
        return LineOfSight(~self._walls & (away_m >= least_m))

    def _is_in_zone(self, cell: Cell) -> bool:
        is_on_map = self.grid.contains(*cell)
        return is_on_map and bool(self.grid.occupied[cell] and not self._walls[cell])

    @cached_property
    def _parts(self) -> npt.NDArray[np.int32]:
        """(rows, cols) the number of the connected part to which a free cell belongs."""
        return np.asarray(ndimage.label(self.free)[0])

    def point(self, positions: npt.ArrayLike) -> Points:
        """Positions in cells, given by north, east and perhaps down in metres."""
        return points_of(self.grid, positions)

    def is_free(self, cell: Cell) -> bool:
        """Whether a cell is free; cells off the map are not."""
        return self.grid.contains(*cell) and bool(self.free[cell])

    def is_clear(self, a: Points, b: Points) -> npt.NDArray[np.bool_]:
        """(...) whether the legs from a to b (..., 2) cross only free cells."""
        return self._free_sight.is_clear(a, b)

    def may_be_clear(self, a: Points, b: Points) -> npt.NDArray[np.bool_]:
        """A quick test of many legs: False only for legs that are not clear."""
        return self._free_sight.may_be_clear(a, b)

    def keeps_away(self, a: Points, b: Points) -> bool:
        """Whether a leg keeps as far from obstacles as its start, or the clearance, less one cell.

        It may leave the fence only if it begins outside. A leg that begins in a zone has to lead
        out of it, to a free cell, and keeps that distance from walls.
        """
        first, last = (self._cell(point) for point in (a, b))
        is_in_zone = self._is_in_zone(first)
        if is_in_zone and not self.is_free(last):
            return False
        obstacles = self._walls_alone if is_in_zone else self.grid
        sight = self._sight_between_walls if is_in_zone else self._open_sight
        points = np.linspace(a, b, 2 + int(2 * math.dist(a, b)))
        cells = np.clip(np.floor(points).astype(int), 0, np.array(self.free.shape) - 1)
        away_m = obstacles.distance_m[cells[:, 0], cells[:, 1]]
        is_inside = self._is_inside[cells[:, 0], cells[:, 1]]
        least_m = min(away_m[0], self._clearance_m) - self.grid.cell_m
        is_kept = away_m.min() >= least_m and (is_inside.all() or not is_inside[0])
        return bool(is_kept and sight.is_clear(a, b))

    def is_connected(self, start: NorthEast, goal: Cell) -> bool:
        """Whether free cells lead from near a start to a cell."""
        if not self.is_free(goal):
            return False
        cell = self.grid.cell(start)
        near = self._parts[self._near(cell)]
        if self._is_in_zone(cell):
            near = self._parts[tuple(self._view(start, cell).cells.T)]
        return bool(np.any(near == self._parts[goal]))

    def are_connected(self, a: Cell, b: Cell) -> bool:
        """Whether free cells lead from one cell to another."""
        return self.is_free(a) and self.is_free(b) and bool(self._parts[a] == self._parts[b])

    def plain_cell(self, start: NorthEast, regions: Regions) -> Cell | None:
        """The cell of a start that is well inside a free cell and not at the border of a region.

        The leg to the centre of that cell is clear and enters no region. Most starts are like this,
        and the test is quick.
        """
        cell = self.grid.cell(start)
        return cell if self._is_plain(self.point(start), cell, regions) else None

    def entry(
        self, start: NorthEast, others: Regions, cost: npt.NDArray[np.float64]
    ) -> Cell | None:
        """The nearest cell to which a leg leads and from which there is a path.

        Args:
            start: where the route begins.
            others: regions that the leg may not enter.
            cost: (rows, cols) cost-to-go; inf if there is no path.
        """
        plain = self.plain_cell(start, others)
        if plain is not None and math.isfinite(cost[plain]):
            return plain
        point, own_cell = self.point(start), self.grid.cell(start)
        view = self._view(start, own_cell)
        cells = view.cells[np.isfinite(cost[view.cells[:, 0], view.cells[:, 1]])]
        near = others.near(point, view.reach + 1)
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
        """How far from a start outside zones a route may enter free cells, in cells."""
        return max(ENTRY_M / self.grid.cell_m, _ENTRY_CELLS)

    @staticmethod
    def _cell(point: Points) -> Cell:
        row, col = np.floor(point).astype(int).tolist()
        return row, col

    def _view(self, start: NorthEast, own_cell: Cell) -> _View:
        """The view from a start; cached, because each place is a start of routes to all others."""
        if start not in self._views:
            point = self.point(start)
            is_free = bool(self._free_sight.is_clear(point, point))
            sight = self._free_sight if is_free else self._open_sight
            near = self._near(own_cell)
            cells = np.argwhere(self.free[near]) + [axis.start for axis in near]
            away = np.linalg.norm(cells - np.array(own_cell), axis=1)
            usable = (away <= self._reach) & sight.is_clear(point, cells + 0.5)
            if len(self._views) >= _MAX_VIEWS:
                self._views.clear()
            nearest = np.argsort(away[usable], kind="stable")
            self._views[start] = _View(is_free, cells[usable][nearest], self._reach)
            if self._is_in_zone(own_cell):
                self._views[start] = self._view_out_of_zone(point)
        return self._views[start]

    def _view_out_of_zone(self, point: Points) -> _View:
        """The nearest free cells to which a leg comes no nearer to walls, at any distance."""
        cells = np.argwhere(self.free)
        centres = np.asarray(cells + 0.5, dtype=np.float64)
        away = np.linalg.norm(centres - point, axis=1)
        nearest = np.argsort(away, kind="stable")
        of_part = nearest[_ranks(self._parts[tuple(cells[nearest].T)]) < _BATCH]
        sight = self._sight_away_from_walls(self._cell(point))
        seen = of_part[sight.is_clear(point, centres[of_part])]
        if not seen.size:
            seen = _first_seen(point, centres, nearest, sight)
        return _View(False, cells[seen], float(away[seen].max(initial=0.0)))

    def _near(self, cell: Cell) -> tuple[slice, slice]:
        """The rows and columns within reach of a cell."""
        reach = self._reach
        row, col = (
            slice(max(math.floor(x - reach), 0), max(math.ceil(x + reach) + 1, 0)) for x in cell
        )
        return row, col

    def _is_plain(self, point: Points, cell: Cell, others: Regions) -> bool:
        """Whether a start is well inside a free cell and not at the border of a region."""
        if not self.is_free(cell):
            return False
        row, col = point.tolist()
        if not (_BORDER < row - cell[0] < 1 - _BORDER and _BORDER < col - cell[1] < 1 - _BORDER):
            return False
        away = others.away(point)
        return not np.any((away >= -_BORDER) & (away <= 1))


def _ranks(numbers: npt.NDArray[np.int32]) -> npt.NDArray[np.intp]:
    """For each number, how many equal ones come before it.

    >>> _ranks(np.array([7, 5, 7, 7, 5], dtype=np.int32)).tolist()
    [0, 0, 1, 2, 1]
    """
    order = np.argsort(numbers, kind="stable")
    begins = np.flatnonzero(np.diff(numbers[order], prepend=-1))
    lengths = np.diff(begins, append=len(numbers))
    ranks = np.empty(len(numbers), dtype=np.intp)
    ranks[order] = np.arange(len(numbers)) - np.repeat(begins, lengths)
    return ranks


def _first_seen(
    point: Points, centres: Points, nearest: npt.NDArray[np.intp], sight: LineOfSight
) -> npt.NDArray[np.intp]:
    """Which of some cells can be seen from a point; stops at the first batch that has any."""
    for some in np.array_split(nearest, max(1, len(nearest) // _BATCH)):
        seen = some[sight.is_clear(point, centres[some])]
        if seen.size:
            return seen
    return nearest[:0]
