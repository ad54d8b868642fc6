"""Straight legs: does a leg cross only free cells, and does it enter a region?

Both answers are exact, for any two points: the cells come from interval arithmetic on the rows
that a leg passes (its supercover), the regions from the distance of a point to a segment.
Nothing is sampled along the leg.

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


class Sight:
    """Which straight legs cross none of a set of blocked cells.

    Args:
        free: (rows, cols) bool; everything outside is blocked.
    """

    def __init__(self, free: npt.NDArray[np.bool_]) -> None:
        self._shape = free.shape
        # A frame of blocked cells, then the number of blocked cells west of each column, so
        # that a run of cells in one row is tested by one subtraction.
        blocked = np.pad(~free, 1, constant_values=True)
        self._blocked_before = np.pad(np.cumsum(blocked, axis=1, dtype=np.int32), ((0, 0), (1, 0)))

    def is_clear(self, a: Points, b: Points) -> bool:
        """Whether the leg between two points crosses free cells only."""
        (row_a, col_a), (row_b, col_b) = sorted((a.tolist(), b.tolist()))
        rows, cols = self._shape
        if row_a < 0 or row_b > rows or not (0 <= col_a <= cols and 0 <= col_b <= cols):
            return False
        band = np.arange(np.floor(row_a - _TOUCH), np.floor(row_b + _TOUCH) + 1)
        if row_b - row_a > _TOUCH:
            slope = (col_b - col_a) / (row_b - row_a)
            enter = col_a + slope * (np.clip(band, row_a, row_b) - row_a)
            leave = col_a + slope * (np.clip(band + 1, row_a, row_b) - row_a)
        else:
            enter, leave = np.full_like(band, col_a), np.full_like(band, col_b)
        row = band.astype(np.intp) + 1  # +1: the frame
        first = np.floor(np.minimum(enter, leave) - _TOUCH).astype(np.intp) + 1
        last = np.floor(np.maximum(enter, leave) + _TOUCH).astype(np.intp) + 1
        blocked = self._blocked_before[row, last + 1] - self._blocked_before[row, first]
        return not blocked.any()


def enters(
    a: Points,
    b: Points,
    centre: Points,
    radius: npt.NDArray[np.float64] | float,
) -> npt.NDArray[np.bool_]:
    """Whether the leg from a to b comes into a disc from outside; leaving one is allowed.

    Args:
        a: (..., 2) where the leg begins.
        b: (..., 2) where it ends.
        centre: (..., 2) centre of the disc.
        radius: (...) in cells; the disc is open, so a leg may touch it.

    Returns:
        (...) bool, after broadcasting the arguments.
    """
    leg = b - a
    to_centre = centre - a
    length2 = np.sum(leg * leg, axis=-1)
    along = np.sum(to_centre * leg, axis=-1) / np.where(length2 > 0, length2, 1.0)
    nearest = to_centre - np.clip(along, 0.0, 1.0)[..., None] * leg
    is_outside = np.hypot(to_centre[..., 0], to_centre[..., 1]) >= radius
    return np.asarray(is_outside & (np.hypot(nearest[..., 0], nearest[..., 1]) < radius))
