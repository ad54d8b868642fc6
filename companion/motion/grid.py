"""Occupancy grid and its distance field: which cells are free, and how near obstacles are.

Row 0 is the southmost row and column 0 the westmost column, so rows grow with north and columns
with east. Cells outside the grid count as occupied, unless the grid is open. An occupied cell is
solid up to its edges: all distances are to edges, never to centres. The distance field tells the
least distance of any point of a cell; the distance of one position is exact.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from companion.geometry import NorthEast

ROUNDING_M = 1e-9
"""The most by which two ways to calculate a distance differ."""


@dataclass(frozen=True, eq=False)
class LowWalls:
    """Walls that have an upper end.

    Attributes:
        tops_m: (rows, cols) upper ends above home, 0 where there is no low wall.
    """

    tops_m: npt.NDArray[np.float64]

    @cached_property
    def heights_m(self) -> tuple[float, ...]:
        """The different heights, the lowest first."""
        return tuple(float(up_m) for up_m in np.unique(self.tops_m) if up_m > 0)


@dataclass(frozen=True, eq=False)
class OccupancyGrid:
    """A map of cells that are occupied or free.

    Attributes:
        occupied: (rows, cols) bool; unknown cells of a map file count as occupied.
        cell_m: edge of a cell.
        origin: north-east position of the outer corner of cell (0, 0).
        is_open: whether cells off the grid are free of obstacles.
        low: walls that can be flown over, whose cells are not occupied; None if there are none.
    """

    occupied: npt.NDArray[np.bool_]
    cell_m: float
    origin: NorthEast
    is_open: bool = False
    low: LowWalls | None = None

    @cached_property
    def distance_m(self) -> npt.NDArray[np.float64]:
        """(rows, cols) metres from the nearest point of each cell to the nearest occupied edge.

        0 in an occupied cell and in those around it, inf if there is no obstacle at all.
        """
        # Two squares (i, j) cells apart, centre to centre, have a gap of (max(i - 1, 0), max(j - 1,
        # 0)) cells. That is the distance between their centres if the walls were a cell thicker.
        padded = np.pad(self.occupied, 1, constant_values=not self.is_open)
        if not padded.any():
            return np.full(self.occupied.shape, math.inf)
        distance = ndimage.distance_transform_edt(~dilated(padded), sampling=self.cell_m)
        return np.asarray(distance)[1:-1, 1:-1]

    def layer(self, up_m: float) -> int:
        """The number of different heights of low walls that an altitude is at or above."""
        return bisect_right(self.low.heights_m, up_m) if self.low else 0

    def in_layer(self, layer: int) -> OccupancyGrid:
        """The grid on which low walls are occupied, except those of the lowest `layer` heights."""
        if self.low is None:
            return self
        if layer not in self._layers:
            lower_m = self.low.heights_m[layer - 1] if layer else 0.0
            occupied = self.occupied | (self.low.tops_m > lower_m)
            self._layers[layer] = replace(self, occupied=occupied, low=None)
        return self._layers[layer]

    def at(self, up_m: float) -> OccupancyGrid:
        """The grid on which low walls are occupied if they end above an altitude."""
        return self.in_layer(self.layer(up_m))

    @cached_property
    def _layers(self) -> dict[int, OccupancyGrid]:
        return {}

    def with_occupied(self, occupied: npt.NDArray[np.bool_]) -> OccupancyGrid:
        """The grid with other occupied cells."""
        return replace(self, occupied=occupied)

    @property
    def corners(self) -> tuple[NorthEast, ...]:
        """North-east positions of its four outer corners."""
        (south, west), (rows, cols) = self.origin, self.occupied.shape
        north, east = south + rows * self.cell_m, west + cols * self.cell_m
        return ((south, west), (south, east), (north, east), (north, west))

    def cell(self, position: NorthEast) -> tuple[int, int]:
        """Row and column of the cell that contains a position; may lie outside the grid."""
        return (
            math.floor((position[0] - self.origin[0]) / self.cell_m),
            math.floor((position[1] - self.origin[1]) / self.cell_m),
        )

    def centre(self, row: int, col: int) -> NorthEast:
        """North-east position of a cell's centre."""
        return (
            self.origin[0] + (row + 0.5) * self.cell_m,
            self.origin[1] + (col + 0.5) * self.cell_m,
        )

    def contains(self, row: int, col: int) -> bool:
        """Whether a cell lies on the grid."""
        rows, cols = self.occupied.shape
        return bool(0 <= row < rows and 0 <= col < cols)

    def clearance_m(self, position: NorthEast) -> float:
        """Distance to the nearest occupied cell's edge; 0 in an occupied cell.

        Off the grid it is also 0, unless the grid is open.
        """
        row, col = self.cell(position)
        point = (np.array(position) - self.origin) / self.cell_m
        if not self.contains(row, col):
            return self._away(point, np.argwhere(self.occupied)) if self.is_open else 0.0
        least = self.distance_m[row, col] / self.cell_m
        if math.isinf(least):
            return math.inf
        reach = math.ceil(least) + 3  # at most a diagonal further than `least`
        first = np.array((row - reach, col - reach))
        south, west = np.maximum(first, 0)
        near = self.occupied[south : row + reach + 1, west : col + reach + 1]
        away_m = self._away(point, np.argwhere(near) + np.array((south, west)))
        if self.is_open:
            return away_m
        to_rim = np.minimum(point, np.array(self.occupied.shape) - point).min()
        return min(away_m, float(to_rim) * self.cell_m)

    def ground_m(self, position: NorthEast, radius_m: float) -> tuple[float, float]:
        """Lowest and highest surface that can carry a vehicle, within a radius of a position.

        Args:
            position: the centre.
            radius_m: 0 for the position alone.

        Returns:
            Metres above home: 0 for the ground, more for the top of a low wall.
        """
        if self.low is None:
            return 0.0, 0.0
        shape, near = self.occupied.shape, []
        for axis in (0, 1):
            point = (position[axis] - self.origin[axis]) / self.cell_m
            reach = radius_m / self.cell_m
            cells = np.arange(math.floor(point - reach), math.floor(point + reach) + 1)
            gaps = np.maximum(np.maximum(cells - point, point - cells - 1), 0.0)
            is_on = (cells >= 0) & (cells < shape[axis])
            near.append((np.clip(cells, 0, shape[axis] - 1), gaps, is_on))
        (rows, south, rows_on), (cols, east, cols_on) = near
        is_near = np.hypot(south[:, None], east[None, :]) * self.cell_m <= radius_m
        tops_m = np.where(rows_on[:, None] & cols_on, self.low.tops_m[rows[:, None], cols], 0.0)
        found = tops_m[is_near]
        return float(found.min()), float(found.max())

    def is_within(self, position: NorthEast, distance_m: float) -> bool:
        """Whether the clearance of a position is less than a distance.

        Most positions are cells away from everything, which the distance field shows at once.

        >>> wall = OccupancyGrid(np.eye(1, 9, dtype=np.bool_), 1.0, (0.0, 0.0), is_open=True)
        >>> wall.is_within((0.5, 3.5), 2.4), wall.is_within((0.5, 3.5), 2.6)
        (False, True)
        """
        row, col = self.cell(position)
        if self.contains(row, col) and self.distance_m[row, col] > distance_m + ROUNDING_M:
            return False
        return self.clearance_m(position) < distance_m

    def _away(self, point: npt.NDArray[np.float64], cells: npt.NDArray[np.int_]) -> float:
        """Metres from a point, in cells, to the nearest of some cells (n, 2)."""
        gaps = np.maximum(np.maximum(cells - point, point - cells - 1), 0.0)
        return float(np.hypot(gaps[:, 0], gaps[:, 1]).min(initial=math.inf)) * self.cell_m


def dilated(occupied: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """The occupied cells and the eight around each."""
    rows = occupied.copy()
    rows[1:] |= occupied[:-1]
    rows[:-1] |= occupied[1:]
    thick = rows.copy()
    thick[:, 1:] |= rows[:, :-1]
    thick[:, :-1] |= rows[:, 1:]
    return thick


def cells_inside(
    grid: OccupancyGrid, polygon: Sequence[NorthEast], margin_m: float = 0.0
) -> npt.NDArray[np.bool_]:
    """Cells with all four corners inside a polygon, and a margin away from its edges.

    The rule is that of `geometry.is_in_polygon`.
    """
    rows, cols = grid.occupied.shape
    north = grid.origin[0] + grid.cell_m * np.arange(rows + 1)[:, None]
    east = grid.origin[1] + grid.cell_m * np.arange(cols + 1)[None, :]
    inside = np.zeros((rows + 1, cols + 1), dtype=np.bool_)
    for (n1, e1), (n2, e2) in zip(polygon, [*polygon[1:], polygon[0]], strict=True):
        if e1 != e2:
            is_west = north < (n2 - n1) * (east - e1) / (e2 - e1) + n1
            inside ^= ((e1 > east) != (e2 > east)) & is_west
    if margin_m > 0:
        for edge in zip(polygon, [*polygon[1:], polygon[0]], strict=True):
            inside &= distances_to_edge(north, east, edge) >= margin_m
    return inside[:-1, :-1] & inside[1:, :-1] & inside[:-1, 1:] & inside[1:, 1:]


def distances_to_edge(
    north: npt.NDArray[np.float64],
    east: npt.NDArray[np.float64],
    edge: tuple[NorthEast, NorthEast],
) -> npt.NDArray[np.float64]:
    """Distances in metres from points to the nearest point of a straight edge.

    >>> distances_to_edge(np.array([3.0, 5.0]), np.array([1.0, 1.0]), ((0.0, 0.0), (2.0, 0.0)))
    array([1.41421356, 3.16227766])
    """
    (n1, e1), (n2, e2) = edge
    length_2 = (n2 - n1) ** 2 + (e2 - e1) ** 2
    along = (north - n1) * (n2 - n1) + (east - e1) * (e2 - e1)
    share = np.clip(along / length_2, 0.0, 1.0) if length_2 else np.zeros_like(along)
    offset_n, offset_e = north - n1 - share * (n2 - n1), east - e1 - share * (e2 - e1)
    return np.asarray(np.hypot(offset_n, offset_e))
