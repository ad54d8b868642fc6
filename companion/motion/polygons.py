"""Polygons: which cells one touches, how far a point is from it, and whether it is valid.

A polygon is the area inside its edges, by the even-odd rule. Its corners are points in cells
(`line_of_sight.py`) or positions in metres, the same throughout a call.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from companion.geometry import NorthEast, is_in_polygon
from companion.motion.grid import OccupancyGrid
from companion.motion.line_of_sight import Points

MAX_CORNERS = 250
"""The most corners of all polygons of a mission: each setpoint is compared with each edge, and the
check of a mission with a comb of that many corners takes two seconds."""

_BATCH = 200_000  # legs times edges that are tested together
_TOUCH = 1e-9  # cells; a thinner part of a cell does not count
_HAIR = 1e-4  # cells


def cells_touched(shape: tuple[int, ...], corners: Points) -> npt.NDArray[np.bool_]:
    """(rows, cols) the cells of which some part, not only an edge or corner, lies in a polygon.

    Exact: the cells that an edge crosses come from interval arithmetic on the rows that it passes;
    every other cell is inside or outside as its centre is.

    >>> triangle = np.array([[0.0, 0.0], [0.0, 3.0], [3.0, 0.0]])
    >>> cells_touched((3, 4), triangle).astype(int).tolist()
    [[1, 1, 1, 0], [1, 1, 0, 0], [1, 0, 0, 0]]

    Args:
        shape: rows and columns of the map.
        corners: (n, 2) of the polygon, in cells.
    """
    a, b = corners, np.roll(corners, -1, axis=0)
    is_northwards = (a[:, 0] <= b[:, 0])[:, None]
    south, north = np.where(is_northwards, a, b), np.where(is_northwards, b, a)
    return _crossed(shape, south, north) | _centres_inside(shape, south, north)


def _crossed(shape: tuple[int, ...], south: Points, north: Points) -> npt.NDArray[np.bool_]:
    """The cells whose interior an edge crosses."""
    rows, cols = shape
    first = np.floor(south[:, 0] + _TOUCH)
    last = np.ceil(north[:, 0] - _TOUCH) - 1
    edge, row = _passed(first, last, rows)
    enter = _columns(south[edge], north[edge], row)
    leave = np.where(
        (north - south)[edge, 0] > _TOUCH,
        _columns(south[edge], north[edge], row + 1),
        north[edge, 1],
    )
    west = np.maximum(np.floor(np.minimum(enter, leave) + _TOUCH), 0).astype(np.intp)
    east = np.minimum(np.ceil(np.maximum(enter, leave) - _TOUCH), cols).astype(np.intp)
    is_met = west < east
    steps = np.zeros((rows, cols + 1), dtype=np.int32)
    np.add.at(steps, (row[is_met], west[is_met]), 1)
    np.add.at(steps, (row[is_met], east[is_met]), -1)
    return np.asarray(np.cumsum(steps, axis=1)[:, :-1] > 0)


def _centres_inside(shape: tuple[int, ...], south: Points, north: Points) -> npt.NDArray[np.bool_]:
    """The cells whose centres are inside the polygon."""
    rows, cols = shape
    first, last = np.ceil(south[:, 0] - 0.5), np.ceil(north[:, 0] - 0.5) - 1
    edge, row = _passed(first, last, rows)
    at = np.ceil(_columns(south[edge], north[edge], row + 0.5) - 0.5)
    turns = np.zeros((rows, cols + 1), dtype=np.int32)
    np.add.at(turns, (row, np.clip(at, 0, cols).astype(np.intp)), 1)
    return np.asarray(np.cumsum(turns, axis=1)[:, :-1] % 2 == 1)


def _passed(first: Points, last: Points, rows: int) -> tuple[npt.NDArray[np.intp], ...]:
    """For each edge and each row of the map that it passes: the numbers of both."""
    low = np.clip(first, 0, rows).astype(np.intp)
    high = np.clip(last, -1, rows - 1).astype(np.intp)
    count = np.maximum(high - low + 1, 0)
    edge = np.repeat(np.arange(len(low)), count)
    return edge, low[edge] + np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count)


def _columns(south: Points, north: Points, row: npt.NDArray[Any]) -> Points:
    """The columns of edges at some rows, or at the edges' nearest ends."""
    rise = north[:, 0] - south[:, 0]
    share = (row - south[:, 0]) / np.where(rise > _TOUCH, rise, 1.0)
    return np.asarray(south[:, 1] + np.clip(share, 0.0, 1.0) * (north[:, 1] - south[:, 1]))


def without_repeats(corners: Sequence[NorthEast]) -> tuple[NorthEast, ...]:
    """The corners of a polygon, each once; some authors repeat the first one at the end."""
    return tuple(
        corner for i, corner in enumerate(corners) if corner != corners[i - 1] or len(corners) == 1
    )


def problem_of(corners: Sequence[NorthEast]) -> str | None:
    """Why some corners, none of them twice in a row, do not form a polygon; None if they do.

    >>> problem_of([(0, 0), (1, 1), (1, 0), (0, 1)])
    'its edges from corner 1 and from corner 3 cross'
    >>> problem_of([(0, 0), (1, 1), (2, 2)])
    'it has no area: its corners are on a line'
    """
    if len(corners) < 3:
        return f"it has {len(corners)} corners, at least 3 are needed"
    if len(corners) > MAX_CORNERS:
        return f"it has {len(corners)} corners, at most {MAX_CORNERS} are allowed"
    a = np.array(corners, dtype=np.float64)
    b = np.roll(a, -1, axis=0)
    longest = float(np.abs(a - a[0]).max())
    across = _cross(a - a[0], a[np.argmax(np.hypot(*(a - a[0]).T))] - a[0])
    if np.abs(across).max() <= _TOUCH * longest * longest:
        return "it has no area: its corners are on a line"
    i, j = np.triu_indices(len(a), k=2)
    is_apart = (j + 1) % len(a) != i
    i, j = i[is_apart], j[is_apart]
    (met,) = np.nonzero(segments_meet(a[i], b[i], a[j], b[j]))
    if len(met):
        return f"its edges from corner {i[met[0]] + 1} and from corner {j[met[0]] + 1} cross"
    return None


def do_overlap(one: Sequence[NorthEast], other: Sequence[NorthEast]) -> bool:
    """Whether two polygons have a point in common.

    >>> do_overlap([(0, 0), (0, 2), (2, 1)], [(1, 1), (1, 3), (3, 2)])
    True
    """
    a, c = np.array(one, dtype=np.float64)[:, None], np.array(other, dtype=np.float64)[None]
    b, d = np.roll(a, -1, axis=0), np.roll(c, -1, axis=1)
    if segments_meet(a, b, c, d).any():
        return True
    return is_in_polygon(one[0], other) or is_in_polygon(other[0], one)


def cells_of(grid: OccupancyGrid, polygons: Iterable[Sequence[NorthEast]]) -> OccupancyGrid:
    """The grid with the cells of some polygons occupied as well; itself if there are none."""
    occupied = grid.occupied
    for corners in polygons:
        points = (np.array(corners) - grid.origin) / grid.cell_m
        occupied = occupied | cells_touched(grid.occupied.shape, points)
    return grid if occupied is grid.occupied else grid.with_occupied(occupied)


def distance_to_edges(points: Points, corners: Points) -> npt.NDArray[np.float64]:
    """(...) distances from points (..., 2) to the nearest edge of a polygon (n, 2)."""
    a = corners
    leg = np.roll(corners, -1, axis=0) - a
    to = points[..., None, :] - a
    share = np.clip(np.sum(to * leg, axis=-1) / np.sum(leg * leg, axis=-1), 0.0, 1.0)
    return np.asarray(np.linalg.norm(to - share[..., None] * leg, axis=-1).min(axis=-1))


def are_inside(points: Points, corners: Points) -> npt.NDArray[np.bool_]:
    """(...) whether points (..., 2) lie in a polygon (n, 2), by the rule of `is_in_polygon`."""
    a, b = corners, np.roll(corners, -1, axis=0)
    row, col = points[..., None, 0], points[..., None, 1]
    rise = np.where(a[:, 1] == b[:, 1], 1.0, b[:, 1] - a[:, 1])
    is_below = row < (b[:, 0] - a[:, 0]) * (col - a[:, 1]) / rise + a[:, 0]
    crossed = ((a[:, 1] > col) != (b[:, 1] > col)) & is_below
    return np.asarray(np.count_nonzero(crossed, axis=-1) % 2 == 1)


def enters_polygon(a: Points, b: Points, corners: Points) -> npt.NDArray[np.bool_]:
    """(...) whether the legs from a to b (..., 2) enter a polygon from outside.

    A leg that touches it from outside counts, too. A leg may leave it, but not enter another arm of
    it.

    >>> arms = np.array([[0.0, 0.0], [0.0, 5.0], [3.0, 5.0], [3.0, 4.0], [1.0, 4.0], [1.0, 0.0]])
    >>> a, b = np.array([0.5, 0.5]), np.array([2.5, 4.5])
    >>> bool(enters_polygon(a, np.array([2.0, 0.5]), arms)), bool(enters_polygon(a, b, arms))
    (False, True)
    """
    a, b = np.broadcast_arrays(a, b)
    low, high = corners.min(axis=0), corners.max(axis=0)
    entered = np.zeros(a.shape[:-1], dtype=np.bool_)
    is_near = np.all((np.minimum(a, b) <= high) & (np.maximum(a, b) >= low), axis=-1)
    a, b = a[is_near], b[is_near]
    found = np.zeros(len(a), dtype=np.bool_)
    ends = np.roll(corners, -1, axis=0)
    for some in np.array_split(np.arange(len(a)), max(1, len(a) * len(corners) // _BATCH)):
        first, last = a[some, None], b[some, None]
        met = segments_meet(first, last, corners, ends).any(axis=-1) | are_inside(b[some], corners)
        has_left = np.count_nonzero(_are_crossed(first, last, corners, ends), axis=-1) > 1
        found[some] = np.where(are_inside(a[some], corners), has_left, met)
    entered[is_near] = found
    return entered


def cells_beside(shape: tuple[int, ...], corners: Points, reach: int) -> npt.NDArray[np.bool_]:
    """(rows, cols) the cells that an edge crosses, and those up to `reach` rows or columns away.

    An edge on the line between two rows, or columns, crosses no cell. If there is a reach, it
    counts as if it lay a hair beyond the line.

    >>> square = np.array([[1.0, 1.0], [1.0, 2.0], [2.0, 2.0], [2.0, 1.0]])
    >>> cells_beside((3, 3), square, 0).any(), cells_beside((3, 3), square, 1).all()
    (np.False_, np.True_)
    """
    crossed = _passed_by(shape, corners)
    if reach:
        crossed |= _passed_by(shape, corners + _HAIR)
    return np.asarray(ndimage.maximum_filter(crossed, size=2 * reach + 1, mode="constant"))


def _passed_by(shape: tuple[int, ...], corners: Points) -> npt.NDArray[np.bool_]:
    """(rows, cols) the cells that an edge crosses."""
    a, b = corners, np.roll(corners, -1, axis=0)
    is_northwards = (a[:, 0] <= b[:, 0])[:, None]
    return _crossed(shape, np.where(is_northwards, a, b), np.where(is_northwards, b, a))


def segments_meet(a: Points, b: Points, c: Points, d: Points) -> npt.NDArray[np.bool_]:
    """(...) whether the segments from a to b and from c to d (..., 2) have a point in common.

    >>> bool(segments_meet(*np.array([[0.0, 0.0], [2.0, 2.0], [0.0, 2.0], [2.0, 0.0]])))
    True
    """
    c_side, d_side = _side(a, b, c), _side(a, b, d)
    a_side, b_side = _side(c, d, a), _side(c, d, b)
    do_cross = (c_side * d_side <= 0) & (a_side * b_side <= 0)
    do_overlap = np.all(
        (np.minimum(a, b) <= np.maximum(c, d)) & (np.minimum(c, d) <= np.maximum(a, b)), axis=-1
    )
    return np.asarray(do_cross & do_overlap)


def _are_crossed(a: Points, b: Points, c: Points, d: Points) -> npt.NDArray[np.bool_]:
    """(...) whether segments a to b cross those c to d; at a shared corner one of two does."""
    is_c_left, is_d_left = _side(a, b, c) > 0, _side(a, b, d) > 0
    is_a_left, is_b_left = _side(c, d, a) > 0, _side(c, d, b) > 0
    return np.asarray((is_c_left != is_d_left) & (is_a_left != is_b_left))


def _side(a: Points, b: Points, point: Points) -> npt.NDArray[np.float64]:
    """The side of a line from a to b on which points are: the sign of the cross product."""
    return np.sign(_cross(b - a, point - a))


def _cross(a: Points, b: Points) -> npt.NDArray[np.float64]:
    """(...) cross products of vectors (..., 2)."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
