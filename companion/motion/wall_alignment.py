"""How far a scan is off from the told walls: what the position is wrong by.

The walls of the prior map stand where they stand. If the echoes of a scan come from half a metre
behind them, the vehicle is half a metre further back than its autopilot takes it to be. The
displacement that lays the echoes onto the walls is found by least squares on the map's signed
distance field, point by point (Fitzgibbon 2003, Robust Registration of 2D and 3D Point Sets): an
echo counts by its distance from the nearest wall, in the direction of that wall.

Echoes too far from any wall come from something that no map shows, and do not count; what is too
far shrinks from pass to pass. Along a straight corridor the echoes say nothing of how far the
vehicle has come, and nothing is changed there.

Left out: errors of the heading.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from companion.geometry import NorthEast
from companion.motion.grid import OccupancyGrid
from companion.motion.range_scan import REACH_M, RangeScan, echoes

INLIER_M = 0.25
"""In the last pass, an echo further from any wall does not count."""
LEAST_ECHOES = 8
"""With fewer that count, a scan says nothing."""
_PASSES = 6
_HELD = 1.0  # weight of staying as it is, in echoes

Floats = npt.NDArray[np.float64]


class WallAlignment:
    """Lays scans onto the walls of a map.

    Args:
        prior: the map of the mission.
    """

    def __init__(self, prior: OccupancyGrid) -> None:
        self._grid = prior
        outside = ndimage.distance_transform_edt(~prior.occupied)
        inside = ndimage.distance_transform_edt(prior.occupied)
        # In cells; the face of a wall lies half a cell before the centres of its first cells.
        self._field = np.where(prior.occupied, 0.5 - inside, outside - 0.5)
        self._slope = np.array(np.gradient(self._field))

    def displacement(self, scan: RangeScan, greatest_m: float) -> NorthEast:
        """What has to be added to the position of a scan; (0, 0) if that cannot be said.

        Args:
            scan: where the vehicle is taken to be, and what it saw.
            greatest_m: the position is off by no more.
        """
        points = (echoes(scan, min(scan.range_m, REACH_M)) - self._grid.origin) / self._grid.cell_m
        moved = np.zeros(2)
        for cutoff_m in np.geomspace(max(greatest_m, INLIER_M), INLIER_M, _PASSES):
            away, slope = self._look_up(points + moved)
            counts = np.abs(away) <= cutoff_m / self._grid.cell_m
            if np.count_nonzero(counts) < LEAST_ECHOES:
                return (0.0, 0.0)
            near, towards = away[counts], slope[counts]
            normal = towards.T @ towards + _HELD * np.eye(2)
            moved = moved - np.linalg.solve(normal, towards.T @ near)
        metres = moved * self._grid.cell_m
        if np.hypot(*metres) > greatest_m:
            return (0.0, 0.0)
        return (float(metres[0]), float(metres[1]))

    def _look_up(self, points: Floats) -> tuple[Floats, Floats]:
        """(n,) signed distance of points (n, 2) from the nearest face, and (n, 2) its slope."""
        at = points.T - 0.5  # of cells' centres
        away = ndimage.map_coordinates(self._field, at, order=1, mode="nearest")
        slope = [ndimage.map_coordinates(axis, at, order=1, mode="nearest") for axis in self._slope]
        return np.asarray(away), np.stack(slope, axis=-1)
