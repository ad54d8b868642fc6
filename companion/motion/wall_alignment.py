"""Finds the errors of position and heading by aligning a scan with the walls of the prior map.

If the echoes of a scan come from half a metre behind a wall, the vehicle is half a metre further
back than its autopilot estimates; if they are at an angle to it, the heading is wrong. The shift
and the turn that bring the echoes onto the walls are found by least squares on the map's signed
distance field (Fitzgibbon 2003, Robust Registration of 2D and 3D Point Sets): an echo counts by its
distance from the nearest wall, in the direction of that wall.

Echoes too far from any wall come from something that no map shows, and are ignored. The limit for
that shrinks from pass to pass. Along a straight corridor echoes do not tell how far the vehicle has
come, so nothing is corrected in that direction.

PX4's heading was wrong by up to 22 degrees in the first seconds of a flight, and by 2 to 11 RMS.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from companion.motion.grid import OccupancyGrid
from companion.motion.range_scan import RangeScan, echoes

INLIER_M = 0.25
"""In the last pass, an echo further from any wall is ignored."""
FIRST_M = 1.0
"""The limit in the first pass: 10 degrees at 6 m."""
LEAST_ECHOES = 8
"""With fewer echoes that count, a scan tells nothing."""
LEAST_SHARE = 0.4
"""At least this share of all echoes has to count, or the scan was aligned with the wrong walls."""
GREATEST_TURN_RAD = math.radians(30.0)
_PASSES = 10
_HELD = 1.0  # weight of leaving the pose unchanged, in echoes
_LEVER_M = 2.0  # lever arm of an echo that would hold the heading

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Displacement:
    """The correction of a pose.

    Attributes:
        north_m, east_m: correction of the position.
        turn_rad: correction of the heading, positive to the east.
    """

    north_m: float = 0.0
    east_m: float = 0.0
    turn_rad: float = 0.0

    def applied(self, scan: RangeScan) -> RangeScan:
        """A scan with its pose corrected."""
        north, east = scan.position
        return replace(
            scan,
            position=(north + self.north_m, east + self.east_m),
            yaw_rad=scan.yaw_rad + self.turn_rad,
        )


NONE = Displacement()


class WallAlignment:
    """Aligns scans with the walls of a map.

    Args:
        prior: the map of the mission.
    """

    def __init__(self, prior: OccupancyGrid) -> None:
        self._grid = prior
        self._has_walls = bool(prior.occupied.any())
        outside = ndimage.distance_transform_edt(~prior.occupied)
        inside = ndimage.distance_transform_edt(prior.occupied)
        # In cells; the face of a wall lies half a cell before the centres of its first cells.
        self._field = np.where(prior.occupied, 0.5 - inside, outside - 0.5)
        self._slope = np.array(np.gradient(self._field))

    def displacement(self, scan: RangeScan, greatest_m: float) -> Displacement:
        """The correction of a scan's pose; NONE if it cannot be determined.

        Args:
            scan: the estimated pose of the vehicle, and what it saw.
            greatest_m: upper limit of the position error.
        """
        if not self._has_walls:
            return NONE
        cell_m = self._grid.cell_m
        lever = _LEVER_M / cell_m
        held = _HELD * np.diag([1.0, 1.0, lever * lever])
        found = NONE
        for cutoff_m in np.geomspace(max(greatest_m, FIRST_M), INLIER_M, _PASSES):
            placed = found.applied(scan)
            points = echoes(placed)[:2].T
            away, slope = self._look_up((points - self._grid.origin) / cell_m)
            counts = np.abs(away) <= cutoff_m / cell_m
            if np.count_nonzero(counts) < max(LEAST_ECHOES, LEAST_SHARE * len(points)):
                return NONE
            arms = (points[counts] - placed.position) / cell_m
            turning = slope[counts, 1] * arms[:, 0] - slope[counts, 0] * arms[:, 1]
            jacobian = np.column_stack([slope[counts], turning])
            normal = jacobian.T @ jacobian + held
            north, east, turn = np.linalg.solve(normal, -jacobian.T @ away[counts]).tolist()
            found = Displacement(
                found.north_m + north * cell_m,
                found.east_m + east * cell_m,
                found.turn_rad + turn,
            )
        is_far = math.hypot(found.north_m, found.east_m) > greatest_m
        return NONE if is_far or abs(found.turn_rad) > GREATEST_TURN_RAD else found

    def _look_up(self, points: Floats) -> tuple[Floats, Floats]:
        """(n,) signed distances of points (n, 2) from the nearest face, and (n, 2) its gradient."""
        at = points.T - 0.5  # relative to the cells' centres
        away = ndimage.map_coordinates(self._field, at, order=1, mode="nearest")
        slope = [ndimage.map_coordinates(axis, at, order=1, mode="nearest") for axis in self._slope]
        return np.asarray(away), np.stack(slope, axis=-1)
