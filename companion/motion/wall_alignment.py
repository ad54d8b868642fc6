"""How far a scan is off from the told walls: what position and heading are wrong by.

The walls of the prior map stand where they stand. If the echoes of a scan come from half a metre
behind them, the vehicle is half a metre further back than its autopilot takes it to be; if they
stand askew, its heading is off. The move and the turn that lay the echoes onto the walls are found
by least squares on the map's signed distance field (Fitzgibbon 2003, Robust Registration of 2D and
3D Point Sets): an echo counts by its distance from the nearest wall, in the direction of that wall.

Echoes too far from any wall come from something that no map shows, and do not count; what is too
far shrinks from pass to pass. Along a straight corridor the echoes say nothing of how far the
vehicle has come, and nothing is changed there.

PX4's heading was off by up to 22 degrees in the first seconds of a flight, and by 2 to 11 RMS.
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
"""In the last pass, an echo further from any wall does not count."""
FIRST_M = 1.0
"""In the first pass: 10 degrees at 6 m."""
LEAST_ECHOES = 8
"""With fewer that count, a scan says nothing."""
LEAST_SHARE = 0.4
"""Of all echoes so many count, or the scan was laid onto the wrong walls."""
GREATEST_TURN_RAD = math.radians(30.0)
_PASSES = 10
_HELD = 1.0  # weight of staying as it is, in echoes
_LEVER_M = 2.0  # of an echo that holds the heading

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Displacement:
    """What a pose has to be changed by.

    Attributes:
        north_m, east_m: of the position.
        turn_rad: of the heading, positive to the east.
    """

    north_m: float = 0.0
    east_m: float = 0.0
    turn_rad: float = 0.0

    def applied(self, scan: RangeScan) -> RangeScan:
        """A scan, placed anew."""
        north, east = scan.position
        return replace(
            scan,
            position=(north + self.north_m, east + self.east_m),
            yaw_rad=scan.yaw_rad + self.turn_rad,
        )


NONE = Displacement()


class WallAlignment:
    """Lays scans onto the walls of a map.

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
        """What the pose of a scan has to be changed by; NONE if that cannot be said.

        Args:
            scan: where the vehicle is taken to be, and what it saw.
            greatest_m: the position is off by no more.
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
        """(n,) signed distance of points (n, 2) from the nearest face, and (n, 2) its slope."""
        at = points.T - 0.5  # of cells' centres
        away = ndimage.map_coordinates(self._field, at, order=1, mode="nearest")
        slope = [ndimage.map_coordinates(axis, at, order=1, mode="nearest") for axis in self._slope]
        return np.asarray(away), np.stack(slope, axis=-1)
