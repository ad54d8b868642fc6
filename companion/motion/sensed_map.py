"""The map as sensed: the prior map of the mission, corrected by range scans.

Each cell has the logarithm of its odds of being occupied (Moravec and Elfes 1985). A scan raises it
where a beam ends and lowers it where beams pass, by the amounts of OctoMap (Hornung et al. 2013,
section 3): 0.7 and 0.4 as probabilities. Upper and lower clamps keep the map ready to change: two
scans with a hit make a free cell occupied, nine without one free it again.

The prior map weighs more:
- An echo within EXPLAINED_M of a wall of the prior map is that wall, displaced by an error of the
  position or of the map. A larger error of the position is removed from a scan beforehand
  (`wall_alignment.py`); the margin of routes covers what is left.
- A beam passes a cell only if its two neighbours reach as far. So beams that graze a wall or a
  corner do not wear it away, and a wall of the prior map disappears only after beams have clearly
  passed through it for seconds.

Low walls of the prior map never change. An echo that one of them explains tells nothing if it is at
most BELOW_M above the wall's end; higher up the cell is like any other.

Left out: the third dimension otherwise, and errors of the position beyond EXPLAINED_M, which look
like obstacles.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from companion.motion.grid import OccupancyGrid
from companion.motion.range_scan import RangeScan, echoes

HIT_LOG_ODDS = 0.85
"""What a hit adds: the log-odds of 0.7."""
MISS_LOG_ODDS = 0.41
"""What a miss subtracts: minus the log-odds of 0.4."""
MIN_LOG_ODDS, MAX_LOG_ODDS = -1.0, 3.5
WALL_LOG_ODDS = 10.0
"""The log-odds of a wall of the prior map, and their upper clamp: 25 scans through it."""
EXPLAINED_M = 0.25
"""An echo this close to a wall of the prior map counts as that wall."""
BELOW_M = 1.0
"""An echo from higher above a wall's end does not come from that wall; its height may be wrong."""
PASSED_ABOVE_M = 0.5
"""A beam that is higher above the vehicle may pass over something that is in the vehicle's way."""
_BEHIND_M = 0.0051  # the cell of an echo is looked up this far behind it
_DIAGONAL = 1.5  # cells; the greatest distance of neighbours, including diagonal ones

Floats = npt.NDArray[np.float64]
Cells = npt.NDArray[np.intp]
"""(n,) flat indices, row * cols + col."""


class SensedMap:
    """The map as the vehicle knows it.

    Args:
        prior: the map of the mission.

    Attributes:
        grid: the occupied cells now; it is another object exactly when a cell has changed.
    """

    def __init__(self, prior: OccupancyGrid) -> None:
        self.grid = prior
        walls = prior.occupied
        self._log_odds = np.where(walls, WALL_LOG_ODDS, MIN_LOG_ODDS).ravel()
        self._max_log_odds = np.where(walls, WALL_LOG_ODDS, MAX_LOG_ODDS).ravel()
        rows, cols = walls.shape
        self._framed_shape = rows + 2, cols + 2  # with a frame, for what is off the map
        self._framed_origin = np.array(prior.origin)[:, None] - prior.cell_m
        self._cell_of_echo = _cell_of_echo(prior)
        self._low_m = _explained_low_m(prior)
        self._find_surface()

    def integrate(self, scan: RangeScan) -> bool:
        """Integrates a scan; True if a cell has become occupied or free."""
        hits, passed = self._hits(scan), self._passed(scan)
        if not passed.size and (self._log_odds[hits] == self._max_log_odds[hits]).all():
            return False  # nothing new, as in nearly all scans
        raised = np.minimum(self._log_odds[hits] + HIT_LOG_ODDS, self._max_log_odds[hits])
        touched = np.concatenate([hits, passed])
        before = self._log_odds[touched]
        self._log_odds[passed] = np.maximum(self._log_odds[passed] - MISS_LOG_ODDS, MIN_LOG_ODDS)
        self._log_odds[hits] = raised
        after = self._log_odds[touched]
        if np.any((before > MIN_LOG_ODDS) != (after > MIN_LOG_ODDS)):
            self._find_surface()
        if np.array_equal(before > 0, after > 0):
            return False
        occupied = (self._log_odds > 0).reshape(self.grid.occupied.shape)
        self.grid = self.grid.with_occupied(occupied)
        return True

    def _find_surface(self) -> None:
        """Finds the cells that can be lowered, without inner ones, which no beam reaches first."""
        rows, cols = self.grid.occupied.shape
        is_raised = (self._log_odds > MIN_LOG_ODDS).reshape(rows, cols)
        is_inside = ndimage.binary_erosion(
            is_raised, np.ones((3, 3), dtype=np.bool_), border_value=1
        )
        self._surface = np.flatnonzero(is_raised & ~is_inside)
        row, col = np.divmod(self._surface, cols)
        south_m, west_m = self.grid.origin
        centres = (row + 0.5) * self.grid.cell_m + south_m, (col + 0.5) * self.grid.cell_m + west_m
        self._surface_at = np.array(centres)  # (2, n) north and east of these cells

    def _hits(self, scan: RangeScan) -> Cells:
        """The cells from which echoes come, some of them twice; echoes off the map are left out.

        A cell is looked up half a centimetre behind the echo, which covers the rounding of a
        distance in the message: an echo comes from a face, and the cell is behind it.
        """
        ends = echoes(scan, _BEHIND_M)
        row, col = np.floor((ends[:2] - self._framed_origin) / self.grid.cell_m).astype(np.intp)
        at = np.ravel_multi_index((row, col), self._framed_shape, mode="clip")
        hits = self._cell_of_echo[at]
        is_news = hits >= 0
        if self._low_m is not None:
            is_news &= self._low_m[at] <= -ends[2] - BELOW_M
        return np.asarray(hits[is_news])

    def _passed(self, scan: RangeScan) -> Cells:
        """The cells of the surface that a beam and its two neighbours have passed.

        A beam passes within half a diagonal of the centre of each cell that it crosses; all cells
        that close count.
        """
        cell_m = self.grid.cell_m
        offsets = self._surface_at - np.array(scan.position)[:, None]
        ahead, right = scan.from_level @ offsets  # in the plane of the beams
        away2 = ahead * ahead + right * right
        (near,) = (away2 < (scan.reach_m - _DIAGONAL * cell_m) ** 2).nonzero()
        away_m = np.sqrt(away2[near])
        clear_m = np.minimum(scan.distances_m, scan.reaches_m(PASSED_ABOVE_M))
        round_m = np.concatenate((clear_m[-1:], clear_m, clear_m[:1]))
        clear_m = np.minimum(np.minimum(round_m[:-2], round_m[2:]), clear_m)  # nan stays nan

        count, turn = len(scan.distances_m), 2 * math.pi / abs(scan.step_rad)
        bearing = np.arctan2(right[near], ahead[near]) - scan.first_rad
        bearing /= scan.step_rad
        bearing -= turn * np.floor(bearing / turn)  # a fifth of the time of %
        nearest = np.rint(bearing)
        beam = nearest.astype(np.intp) % round(turn)
        is_clear = (beam < count) & (
            away_m < clear_m[np.minimum(beam, count - 1)] - _DIAGONAL * cell_m
        )
        (clear,) = is_clear.nonzero()
        if not clear.size:
            return np.asarray(clear)  # no beam passes through a wall, as in nearly all scans
        aside = np.abs(bearing - nearest)[clear] * abs(scan.step_rad)
        is_crossed = away_m[clear] * np.sin(aside) <= math.sqrt(0.5) * cell_m
        return np.asarray(self._surface[near[clear[is_crossed]]])


def _explained_low_m(prior: OccupancyGrid) -> Floats | None:
    """(n,) the upper end of the low walls from which an echo in each cell may come.

    -inf if it comes from none. The cells are those of the map and of a frame around it.
    """
    if prior.low is None:
        return None
    reach = math.ceil(max(EXPLAINED_M / prior.cell_m, _DIAGONAL))
    highest = ndimage.maximum_filter(prior.low.tops_m, size=2 * reach + 1, mode="constant")
    return np.pad(np.where(highest > 0, highest, -math.inf), 1, constant_values=-math.inf).ravel()


def _cell_of_echo(prior: OccupancyGrid) -> Cells:
    """(n,) for an echo in each cell, the flat index of the cell from which it comes.

    The cells are those of the map and of a frame around it. Outside a map that is not open
    everything is a wall; an echo from there, or from the frame, has a negative index.
    """
    rows, cols = prior.occupied.shape
    own = np.arange(rows * cols, dtype=np.intp).reshape(rows, cols)
    if prior.is_open and not prior.occupied.any():
        return np.pad(own, 1, constant_values=-1).ravel()
    away, nearest = ndimage.distance_transform_edt(
        np.pad(~prior.occupied, 1, constant_values=prior.is_open),
        sampling=prior.cell_m,
        return_indices=True,
    )
    away, (row, col) = away[1:-1, 1:-1], nearest[:, 1:-1, 1:-1] - 1
    is_on_map = (row >= 0) & (row < rows) & (col >= 0) & (col < cols)
    wall = np.where(is_on_map, row * cols + col, -1)
    is_explained = away <= max(EXPLAINED_M, _DIAGONAL * prior.cell_m)
    return np.pad(np.where(is_explained, wall, own), 1, constant_values=-1).ravel()
