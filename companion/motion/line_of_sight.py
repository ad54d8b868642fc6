"""Straight legs: whether a leg crosses only free cells, and whether it enters a disc.

Both answers are exact for any two points: the cells come from interval arithmetic on the rows that
a leg passes (its supercover), the discs from the distance of a point to a segment. The leg is not
sampled.

Points are (row, column) in units of cells, so that cell (r, c) is the square [r, r + 1] x
[c, c + 1] and its centre is (r + 0.5, c + 0.5). A leg that only touches a cell's edge or corner
crosses that cell too: no leg slips between two blocked cells that meet in a corner.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Points = npt.NDArray[np.float64]
"""(..., 2) row, column, in cells."""

_TOUCH = 1e-9  # cells; a leg this close to a cell touches it
_SAMPLES = (np.arange(16) + 0.5) / 16  # positions along a leg, as shares of it


class LineOfSight:
    """Lines of sight over a map: the straight legs that cross free cells only.

    Args:
        free: (rows, cols) bool; everything outside is blocked.

    >>> sight = LineOfSight(np.array([[True, True], [True, False]]))
    >>> bool(sight.is_clear(np.array([0.5, 0.5]), np.array([0.5, 1.5])))
    True
    >>> bool(sight.is_clear(np.array([0.5, 1.5]), np.array([1.5, 0.5])))  # touches the blocked cell
    False
    """

    def __init__(self, free: npt.NDArray[np.bool_]) -> None:
        self._shape = free.shape
        self._free = free
        # A frame of blocked cells, then the number of blocked cells west of each column, so
        # that a run of cells in one row is tested by one subtraction.
        blocked = np.pad(~free, 1, constant_values=True)
        self._blocked_before = np.pad(np.cumsum(blocked, axis=1, dtype=np.int32), ((0, 0), (1, 0)))

    def is_clear(self, a: Points, b: Points) -> npt.NDArray[np.bool_]:
        """Whether the legs between two points cross only free cells.

        Args:
            a: (..., 2) one end of each leg.
            b: (..., 2) the other end.

        Returns:
            (...) bool, after broadcasting the arguments.
        """
        a, b = np.broadcast_arrays(a, b)
        limits = np.array(self._shape)
        is_on_map = np.all((np.minimum(a, b) >= 0) & (np.maximum(a, b) <= limits), axis=-1)
        is_northwards = (a[..., 0] <= b[..., 0])[..., None]
        south = _clipped(0, np.where(is_northwards, a, b), limits)
        north = _clipped(0, np.where(is_northwards, b, a), limits)
        return np.asarray(is_on_map & ~self._is_blocked(south, north))

    def may_be_clear(self, a: Points, b: Points) -> npt.NDArray[np.bool_]:
        """A quick test by samples: False only for legs that are not clear; arguments as above."""
        row = a[..., 0, None] + _SAMPLES * (b - a)[..., 0, None]
        col = a[..., 1, None] + _SAMPLES * (b - a)[..., 1, None]
        rows, cols = self._shape
        cells = (
            _clipped(0, row, rows - 1).astype(np.intp),
            _clipped(0, col, cols - 1).astype(np.intp),
        )
        return np.asarray(self._free[cells].all(axis=-1))

    def _is_blocked(self, south: Points, north: Points) -> npt.NDArray[np.bool_]:
        """Whether legs on the map, from their south end to their north end, meet a blocked cell."""
        row_0, col_0 = south[..., None, 0], south[..., None, 1]
        row_1, col_1 = north[..., None, 0], north[..., None, 1]
        is_level = row_1 - row_0 <= _TOUCH
        slope = (col_1 - col_0) / np.where(is_level, 1.0, row_1 - row_0)

        # Along the last axis: the rows of cells that a leg passes, with its last row repeated.
        first, last = np.floor(row_0 - _TOUCH), np.floor(row_1 + _TOUCH)
        row = np.minimum(first + np.arange(np.max(last - first, initial=0) + 1), last)
        enter = col_0 + slope * (_clipped(row_0, row, row_1) - row_0)
        leave = col_0 + slope * (_clipped(row_0, row + 1, row_1) - row_0)
        leave = np.where(is_level, col_1, leave)
        west = np.floor(np.minimum(enter, leave) - _TOUCH)
        east = np.floor(np.maximum(enter, leave) + _TOUCH)

        row, west, east = (cells.astype(np.intp) + 1 for cells in (row, west, east))  # the frame
        blocked = self._blocked_before[row, east + 1] - self._blocked_before[row, west]
        return np.asarray(np.any(blocked > 0, axis=-1))


def _clipped(low: npt.ArrayLike, values: Points, high: npt.ArrayLike) -> Points:
    """Does the same as numpy.clip, which is slow for small arrays."""
    return np.minimum(np.maximum(values, low), high)


def enters_disc(
    a: Points,
    b: Points,
    centre: Points,
    radius: npt.NDArray[np.float64] | float,
) -> npt.NDArray[np.bool_]:
    """Whether the leg from a to b enters a disc from outside; leaving it is allowed.

    Args:
        a: (..., 2) where the leg begins.
        b: (..., 2) where it ends.
        centre: (..., 2) centre of the disc.
        radius: (...) in cells; the disc is open, so a leg may touch it.

    Returns:
        (...) bool, after broadcasting the arguments.

    >>> west, east, middle = np.array([0.0, -2.0]), np.array([0.0, 2.0]), np.zeros(2)
    >>> bool(enters_disc(west, east, middle, 1.0)), bool(enters_disc(middle, east, middle, 1.0))
    (True, False)
    """
    leg = b - a
    to_centre = centre - a
    length2 = np.sum(leg * leg, axis=-1)
    along = np.sum(to_centre * leg, axis=-1) / np.where(length2 > 0, length2, 1.0)
    nearest = to_centre - _clipped(0.0, along, 1.0)[..., None] * leg
    is_outside = np.hypot(to_centre[..., 0], to_centre[..., 1]) >= radius
    return np.asarray(is_outside & (np.hypot(nearest[..., 0], nearest[..., 1]) < radius))
