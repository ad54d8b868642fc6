"""Which cells are occupied, as far as the vehicle has seen: the told map, corrected by scans.

Each cell has the logarithm of its odds to be occupied (Moravec and Elfes 1985). A scan raises it
where a beam ends and lowers it where beams pass, by the amounts of OctoMap (Hornung et al. 2013,
section 3): 0.7 and 0.4 as probabilities. Clamps at both ends keep the map ready to change: two
scans with a hit make a free cell occupied, nine without free it again.

What the vehicle was told weighs more:
- An echo within `explained_m` of a told wall is that wall, displaced by an error of the position
  or of the map; the margin of routes (0.25 m, `mission/loader.py`) covers that much.
- A beam passes a cell only if its two neighbours get as far. So no beam that grazes a wall or a
  corner wears it away, and told walls go only when they are clearly seen through, for seconds.

Left out: tilt, the third dimension, and errors of the position beyond `explained_m`, which show up
as obstacles.
"""

from __future__ import annotations

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
_DIAGONAL = 1.5  # cells; next to each other, corners included

Floats = npt.NDArray[np.float64]


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

    def integrate(self, scan: RangeScan) -> bool:
        """Takes in a scan; whether a cell has become occupied or free."""
        reach_m = min(scan.range_m, REACH_M)
        ends_m = scan.distances_m
        angles = scan.first_rad + scan.step_rad * np.arange(len(ends_m))
        beams = np.column_stack([np.cos(angles), np.sin(angles)])
        is_echo = ends_m <= reach_m  # false for nan
        hits = self._cells(scan.position, beams[is_echo], ends_m[is_echo])
        hits = self._meant[hits]
        passed = self._passed(scan, beams, reach_m)

        raised = np.minimum(self._odds[hits] + HIT, self._most[hits])
        touched = np.concatenate([hits, passed])
        was_occupied = self._odds[touched] > 0
        self._odds[passed] = np.maximum(self._odds[passed] - MISS, LEAST)
        self._odds[hits] = raised
        if np.array_equal(was_occupied, self._odds[touched] > 0):
            return False
        occupied = (self._odds > 0).reshape(self.grid.occupied.shape)
        self.grid = OccupancyGrid(occupied, self.grid.cell_m, self.grid.origin)
        return True

    def _passed(self, scan: RangeScan, beams: Floats, reach_m: float) -> npt.NDArray[np.intp]:
        """Cells that a beam and its two neighbours have passed; a cell may come twice.

        The beams' points are one cell apart, so a corner that a beam cuts may be left out.
        """
        cell_m = self.grid.cell_m
        known_m = np.nan_to_num(scan.distances_m, nan=0.0, posinf=reach_m)
        clear_m = np.minimum(known_m, np.minimum(np.roll(known_m, 1), np.roll(known_m, -1)))
        along_m = np.arange(0.0, reach_m, cell_m)
        beam, point = np.nonzero(along_m < (clear_m - _DIAGONAL * cell_m)[:, None])
        return self._cells(scan.position, beams[beam], along_m[point])

    def _cells(self, position: NorthEast, beams: Floats, along_m: Floats) -> npt.NDArray[np.intp]:
        """Flat indices of the cells at distances along beams; those off the map are left out.

        The points lie half a hundredth of a metre further, the rounding of a distance on the
        wire, so that an echo from a face lies in the cell behind it.
        """
        rows, cols = self.grid.occupied.shape
        points = np.array(position) - self.grid.origin + beams * (along_m + 0.0051)[:, None]
        cells = np.floor(points / self.grid.cell_m).astype(np.intp)
        is_on_map = np.all((cells >= 0) & (cells < (rows, cols)), axis=1)
        return np.asarray(cells[is_on_map] @ (cols, 1))


def _meant(told: OccupancyGrid) -> npt.NDArray[np.intp]:
    """(rows * cols,) for an echo in each cell, the flat index of the cell that it speaks of."""
    rows, cols = told.occupied.shape
    own = np.arange(rows * cols)
    if not told.occupied.any():
        return own
    away, nearest = ndimage.distance_transform_edt(
        ~told.occupied, sampling=told.cell_m, return_indices=True
    )
    is_explained = away.ravel() <= max(EXPLAINED_M, _DIAGONAL * told.cell_m)
    wall = nearest[0].ravel() * cols + nearest[1].ravel()
    return np.asarray(np.where(is_explained, wall, own), dtype=np.intp)
