"""Occupancy grid and its distance field: the cells that are free, and the nearest obstacles.

Row 0 is the southmost row and column 0 the westmost column, so that row grows with north and
column with east. Cells outside the grid count as occupied. An occupied cell is solid up to its
edges: all distances are to edges, never to centres. The distance field tells how near any point of
a cell may be; the distance of one position is exact.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from companion.geometry import NorthEast


@dataclass(frozen=True)
class OccupancyGrid:
    """Cells that are occupied.

    Attributes:
        occupied: (rows, cols) bool; unknown cells of a map file count as occupied.
        cell_m: edge of a cell.
        origin: north-east position of the outer corner of cell (0, 0).
    """

    occupied: npt.NDArray[np.bool_]
    cell_m: float
    origin: NorthEast
    distance_m: npt.NDArray[np.float64] = field(init=False, repr=False, compare=False)
    """(rows, cols) metres from the nearest point of each cell to the nearest occupied cell's edge;
    0 in an occupied cell and in those around it."""

    def __post_init__(self) -> None:
        # Two squares (i, j) cells apart, centre to centre, have a gap of (max(i - 1, 0), max(j - 1,
        # 0)) cells: the distance between their centres if the walls were a cell thicker.
        padded = np.pad(self.occupied, 1, constant_values=True)  # outside is occupied
        distance = ndimage.distance_transform_edt(~_thickened(padded), sampling=self.cell_m)
        object.__setattr__(self, "distance_m", np.asarray(distance)[1:-1, 1:-1])

    def cell(self, position: NorthEast) -> tuple[int, int]:
        """Row and column of the cell that holds a position; may lie outside the grid."""
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
        """Distance to the nearest occupied cell's edge; 0 in an occupied cell or off the grid."""
        row, col = self.cell(position)
        if not self.contains(row, col):
            return 0.0
        point = (np.array(position) - self.origin) / self.cell_m
        least = self.distance_m[row, col] / self.cell_m
        reach = math.ceil(least) + 3  # it is less than a diagonal further from the point than least
        first = np.array((row - reach, col - reach))
        south, west = np.maximum(first, 0)
        near = self.occupied[south : row + reach + 1, west : col + reach + 1]
        cells = np.argwhere(near) + np.array((south, west))
        gaps = np.maximum(np.maximum(cells - point, point - cells - 1), 0.0)
        away = np.hypot(gaps[:, 0], gaps[:, 1]).min(initial=math.inf)
        to_rim = np.minimum(point, np.array(self.occupied.shape) - point).min()
        return float(min(away, to_rim)) * self.cell_m


def _thickened(occupied: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
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
    """Distances from points to the nearest one of a straight edge, metres.

    >>> distances_to_edge(np.array([3.0, 5.0]), np.array([1.0, 1.0]), ((0.0, 0.0), (2.0, 0.0)))
    array([1.41421356, 3.16227766])
    """
    (n1, e1), (n2, e2) = edge
    length_2 = (n2 - n1) ** 2 + (e2 - e1) ** 2
    along = (north - n1) * (n2 - n1) + (east - e1) * (e2 - e1)
    share = np.clip(along / length_2, 0.0, 1.0) if length_2 else np.zeros_like(along)
    offset_n, offset_e = north - n1 - share * (n2 - n1), east - e1 - share * (e2 - e1)
    return np.asarray(np.hypot(offset_n, offset_e))
