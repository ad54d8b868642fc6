"""The map as sensed: the prior map of the mission, corrected by range scans.

Each cell has the logarithm of its odds to be occupied (Moravec and Elfes 1985). A scan raises it
where a beam ends and lowers it where beams pass, by the amounts of OctoMap (Hornung et al. 2013,
section 3): 0.7 and 0.4 as probabilities. Clamps at both ends keep the map ready to change: two
scans with a hit make a free cell occupied, nine without free it again.

The prior map weighs more:
- An echo near a wall of the prior map is that wall, displaced by an error of the map (EXPLAINED_M)
  or of the position (`position_error.py`); what routes keep from obstacles covers either.
- A beam passes a cell only if its two neighbours get as far. So no beam that grazes a wall or a
  corner wears it away, and a wall of the prior map goes only when beams pass through it clearly,
  for seconds: by twice the error of the position, as they may meet it at a slant.

So an obstacle that stands nearer to a told wall than the position is good for is not seen.
Left out: tilt, and the third dimension.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from companion.geometry import NorthEast
from companion.motion.grid import OccupancyGrid
from companion.motion.position_error import greatest_error_m

HIT_LOG_ODDS = 0.85
"""Added by a hit: the log-odds of 0.7."""
MISS_LOG_ODDS = 0.41
"""Taken away by a miss: minus the log-odds of 0.4."""
MIN_LOG_ODDS, MAX_LOG_ODDS = -1.0, 3.5
WALL_LOG_ODDS = 10.0
"""Of a wall of the prior map, and its upper clamp: 25 scans through it."""
REACH_M = 8.0
"""Echoes from farther away are not used: at 2 m above ground a beam that is tilted by 14 degrees,
the tilt of an acceleration of 2.5 m/s2, meets the ground there."""
EXPLAINED_M = 0.25
"""An echo this close to a wall of the prior map is that wall, however good the position is."""
_BEHIND_M = 0.0051  # the cell of an echo is looked for this far behind it
_DIAGONAL = 1.5  # cells; next to each other, corners included

Floats = npt.NDArray[np.float64]
Cells = npt.NDArray[np.intp]
"""(n,) flat indices, row * cols + col."""


@dataclass(frozen=True, slots=True, eq=False)
class RangeScan:
    """Distances all around, from where the vehicle was when they were measured.

    Attributes:
        stamp_s: time of reception.
        position: of the vehicle, in the mission's frame.
        distances_m: (n,) along each beam; inf: nothing within the range; nan: not known.
        first_rad: direction of the first beam, 0 is north, positive to the east.
        step_rad: angle from one beam to the next; negative to the left.
        range_m: greatest distance that is measured.
        accuracy_m: of the position: a standard deviation, north and east together.
    """

    stamp_s: float
    position: NorthEast
    distances_m: Floats
    first_rad: float
    step_rad: float
    range_m: float
    accuracy_m: float = 0.0


class SensedMap:
    """The map as the vehicle knows it.

    Args:
        prior: the map of the mission.

    Attributes:
        grid: the cells that are occupied now; another object exactly when a cell has changed.
    """

    def __init__(self, prior: OccupancyGrid) -> None:
        self.grid = prior
        walls = prior.occupied
        self._log_odds = np.where(walls, WALL_LOG_ODDS, MIN_LOG_ODDS).ravel()
        self._max_log_odds = np.where(walls, WALL_LOG_ODDS, MAX_LOG_ODDS).ravel()
        self._nearest_wall, self._to_wall_m = _nearest_walls(prior)
        self._find_surface()

    def integrate(self, scan: RangeScan) -> bool:
        """Takes in a scan; True if a cell has become occupied or free."""
        reach_m = min(scan.range_m, REACH_M)
        hits, passed = self._hits(scan, reach_m), self._passed(scan, reach_m)
        if not passed.size and (self._log_odds[hits] == self._max_log_odds[hits]).all():
            return False  # nothing new, as nearly always
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
        self.grid = OccupancyGrid(occupied, self.grid.cell_m, self.grid.origin)
        return True

    def _find_surface(self) -> None:
        """Finds the cells that can be lowered, without inner ones, which no beam reaches first."""
        rows, cols = self.grid.occupied.shape
        is_raised = (self._log_odds > MIN_LOG_ODDS).reshape(rows, cols)
        is_inside = ndimage.binary_erosion(
            is_raised, np.ones((3, 3), dtype=np.bool_), border_value=1
        )
        self._surface = np.flatnonzero(is_raised & ~is_inside)
        cells = np.stack(np.divmod(self._surface, cols)) + 0.5
        self._centres = cells * self.grid.cell_m + np.array(self.grid.origin)[:, None]
        self._is_told = self._max_log_odds[self._surface] == WALL_LOG_ODDS

    def _hits(self, scan: RangeScan, reach_m: float) -> Cells:
        """The cells that echoes come from, some of them twice; echoes off the map are left out.

        A cell is looked for half a centimetre behind the echo, the rounding of a distance on the
        wire: an echo comes from a face, and the cell is behind it.
        """
        rows, cols = self.grid.occupied.shape
        (beams,) = np.nonzero(scan.distances_m <= reach_m)  # nan is none
        angles = scan.first_rad + scan.step_rad * beams
        ends_m = scan.distances_m[beams] + _BEHIND_M
        north = scan.position[0] - self.grid.origin[0] + ends_m * np.cos(angles)
        east = scan.position[1] - self.grid.origin[1] + ends_m * np.sin(angles)
        cell_m = self.grid.cell_m
        row = np.floor(north / cell_m).astype(np.intp)
        col = np.floor(east / cell_m).astype(np.intp)
        is_on_map = (row >= 0) & (row < rows) & (col >= 0) & (col < cols)
        own = row[is_on_map] * cols + col[is_on_map]
        explained_m = max(EXPLAINED_M, _DIAGONAL * cell_m, greatest_error_m(scan.accuracy_m))
        is_wall = self._to_wall_m[own] <= explained_m
        hits = np.where(is_wall, self._nearest_wall[own], own)
        return np.asarray(hits[hits >= 0])

    def _passed(self, scan: RangeScan, reach_m: float) -> Cells:
        """The cells of the surface that a beam and its two neighbours have passed.

        A beam passes within half a diagonal of the centre of each cell that it crosses; all cells
        that close count.
        """
        cell_m = self.grid.cell_m
        north, east = self._centres - np.array(scan.position)[:, None]
        away2 = north * north + east * east
        (near,) = np.nonzero(away2 < (reach_m - _DIAGONAL * cell_m) ** 2)
        north, east, away_m = north[near], east[near], np.sqrt(away2[near])
        round_m = np.concatenate((scan.distances_m[-1:], scan.distances_m, scan.distances_m[:1]))
        clear_m = np.minimum(np.minimum(round_m[:-2], round_m[2:]), scan.distances_m)  # nan is nan

        count, turn = len(scan.distances_m), 2 * math.pi / abs(scan.step_rad)
        bearing = (np.arctan2(east, north) - scan.first_rad) / scan.step_rad  # in steps
        bearing -= turn * np.floor(bearing / turn)  # a fifth of the time of %
        nearest = np.rint(bearing)
        beam = nearest.astype(np.intp) % round(turn)
        beyond_m = np.where(self._is_told[near], self._beyond_told_m(scan), _DIAGONAL * cell_m)
        is_clear = (beam < count) & (away_m < clear_m[np.minimum(beam, count - 1)] - beyond_m)
        aside = np.abs(bearing - nearest)[is_clear] * abs(scan.step_rad)
        is_crossed = away_m[is_clear] * np.sin(aside) <= math.sqrt(0.5) * cell_m
        return np.asarray(self._surface[near[is_clear][is_crossed]])

    def _beyond_told_m(self, scan: RangeScan) -> float:
        """How far a beam has to get behind a wall of the prior map to have passed it."""
        return max(_DIAGONAL * self.grid.cell_m, 2 * greatest_error_m(scan.accuracy_m))


def _nearest_walls(prior: OccupancyGrid) -> tuple[Cells, Floats]:
    """(rows * cols,) the wall that is nearest to each cell, and how far away it is, in metres.

    Outside the map everything is a wall, of which the index is negative.
    """
    rows, cols = prior.occupied.shape
    away, nearest = ndimage.distance_transform_edt(
        np.pad(~prior.occupied, 1), sampling=prior.cell_m, return_indices=True
    )
    away, (row, col) = away[1:-1, 1:-1], nearest[:, 1:-1, 1:-1] - 1
    is_on_map = (row >= 0) & (row < rows) & (col >= 0) & (col < cols)
    wall = np.where(is_on_map, row * cols + col, -1)
    return np.asarray(wall.ravel(), dtype=np.intp), np.asarray(away.ravel())
