"""Which cells are occupied, as far as the vehicle has seen: the told map, corrected by scans.

Each cell has the logarithm of its odds to be occupied (Moravec and Elfes 1985). A scan raises it
where a beam ends and lowers it where beams pass, by the amounts of OctoMap (Hornung et al. 2013,
section 3): 0.7 and 0.4 as probabilities. Clamps at both ends keep the map ready to change: two
scans with a hit make a free cell occupied, nine without free it again.

What the vehicle was told weighs more:
- An echo within `explained_m` of a told wall is that wall, displaced by an error of the position
  or of the map; what routes keep beside the vehicle (0.25 m, `mission/loader.py`) covers it.
- A beam passes a cell only if its two neighbours get as far. So no beam that grazes a wall or a
  corner wears it away, and told walls go only when they are clearly seen through, for seconds.

Left out: tilt, the third dimension, and errors of the position beyond `explained_m`, which show up
as obstacles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from companion.geometry import NorthEast
from companion.motion.grid import OccupancyGrid

HIT, MISS = 0.85, 0.41
"""Log-odds of 0.7 and (lowering) of 0.4."""
LEAST, MOST = -1.0, 3.5
WALL = 10.0
"""Of a told wall, and its upper clamp: 25 scans through it."""
REACH_M = 8.0
"""Echoes from farther away are not used: at 2 m above ground a beam that is tilted by 14 degrees,
the tilt of an acceleration of 2.5 m/s2, meets the ground there."""
EXPLAINED_M = 0.25
_BEHIND_M = 0.0051
_DIAGONAL = 1.5  # cells; next to each other, corners included

Floats = npt.NDArray[np.float64]
Cells = npt.NDArray[np.intp]
"""(n,) flat indices, row * cols + col."""


@dataclass(frozen=True, slots=True, eq=False)
class RangeScan:
    """Distances all around, from where the vehicle was when they were measured.

    Attributes:
        stamp_s: when it was heard.
        position: where the vehicle was, in the mission's frame.
        distances_m: (n,) along each beam; inf: nothing within the range; nan: not known.
        first_rad: direction of the first beam, 0 is north, positive to the east.
        step_rad: from one beam to the next; negative to the left.
        range_m: the farthest that is seen.
    """

    stamp_s: float
    position: NorthEast
    distances_m: Floats
    first_rad: float
    step_rad: float
    range_m: float


class SensedMap:
    """The map as the vehicle knows it.

    Args:
        told: the map of the mission.

    Attributes:
        grid: what is occupied now; another object exactly when a cell has changed.
    """

    def __init__(self, told: OccupancyGrid) -> None:
        self.grid = told
        walls = told.occupied
        self._odds = np.where(walls, WALL, LEAST).ravel()
        self._most = np.where(walls, WALL, MOST).ravel()
        self._meant = _meant(told)
        self._find_surface()

    def integrate(self, scan: RangeScan) -> bool:
        """Takes in a scan; whether a cell has become occupied or free."""
        reach_m = min(scan.range_m, REACH_M)
        hits, passed = self._hits(scan, reach_m), self._passed(scan, reach_m)
        if not passed.size and (self._odds[hits] == self._most[hits]).all():
            return False  # all is as it is known, as nearly always
        raised = np.minimum(self._odds[hits] + HIT, self._most[hits])
        touched = np.concatenate([hits, passed])
        before = self._odds[touched]
        self._odds[passed] = np.maximum(self._odds[passed] - MISS, LEAST)
        self._odds[hits] = raised
        after = self._odds[touched]
        if np.any((before > LEAST) != (after > LEAST)):
            self._find_surface()
        if np.array_equal(before > 0, after > 0):
            return False
        occupied = (self._odds > 0).reshape(self.grid.occupied.shape)
        self.grid = OccupancyGrid(occupied, self.grid.cell_m, self.grid.origin)
        return True

    def _find_surface(self) -> None:
        """The cells that can be lowered, but for those inside: no beam gets there first."""
        rows, cols = self.grid.occupied.shape
        is_raised = (self._odds > LEAST).reshape(rows, cols)
        is_inside = ndimage.binary_erosion(
            is_raised, np.ones((3, 3), dtype=np.bool_), border_value=1
        )
        self._surface = np.flatnonzero(is_raised & ~is_inside)
        cells = np.stack(np.divmod(self._surface, cols)) + 0.5
        self._centres = cells * self.grid.cell_m + np.array(self.grid.origin)[:, None]

    def _hits(self, scan: RangeScan, reach_m: float) -> Cells:
        """The cells that echoes speak of; a cell may come twice. Echoes off the map are left out.

        They are looked for half a centimetre behind the echo, the rounding of a distance on the
        wire: an echo comes from a face, and the cell is behind it.
        """
        rows, cols = self.grid.occupied.shape
        (beams,) = np.nonzero(scan.distances_m <= reach_m)  # nan is none
        angles = scan.first_rad + scan.step_rad * beams
        ends_m = scan.distances_m[beams] + _BEHIND_M
        north = scan.position[0] - self.grid.origin[0] + ends_m * np.cos(angles)
        east = scan.position[1] - self.grid.origin[1] + ends_m * np.sin(angles)
        row = np.floor(north / self.grid.cell_m).astype(np.intp)
        col = np.floor(east / self.grid.cell_m).astype(np.intp)
        is_on_map = (row >= 0) & (row < rows) & (col >= 0) & (col < cols)
        meant = self._meant[row[is_on_map] * cols + col[is_on_map]]
        return np.asarray(meant[meant >= 0])

    def _passed(self, scan: RangeScan, reach_m: float) -> Cells:
        """The cells that a beam and its two neighbours have passed, of those on the surface.

        A beam that crosses a cell has its centre within half a diagonal; all these count.
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
        is_clear = (beam < count) & (
            away_m < clear_m[np.minimum(beam, count - 1)] - _DIAGONAL * cell_m
        )
        aside = np.abs(bearing - nearest)[is_clear] * abs(scan.step_rad)
        is_crossed = away_m[is_clear] * np.sin(aside) <= math.sqrt(0.5) * cell_m
        return np.asarray(self._surface[near[is_clear][is_crossed]])


def _meant(told: OccupancyGrid) -> Cells:
    """(rows * cols,) for an echo in each cell, the flat index of the cell that it speaks of.

    Outside the map everything is a wall; what speaks of it is negative.
    """
    rows, cols = told.occupied.shape
    away, nearest = ndimage.distance_transform_edt(
        np.pad(~told.occupied, 1), sampling=told.cell_m, return_indices=True
    )
    away, (row, col) = away[1:-1, 1:-1], nearest[:, 1:-1, 1:-1] - 1
    is_on_map = (row >= 0) & (row < rows) & (col >= 0) & (col < cols)
    wall = np.where(is_on_map, row * cols + col, -1)
    own = np.arange(rows * cols).reshape(rows, cols)
    is_explained = away <= max(EXPLAINED_M, _DIAGONAL * told.cell_m)
    return np.asarray(np.where(is_explained, wall, own).ravel(), dtype=np.intp)
