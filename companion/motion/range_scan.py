"""Range scans: distances all around the vehicle, and the points from which echoes come.

A range finder is fixed to its vehicle. Its beams lie in one plane, which leans as the vehicle
leans. So a beam tells something about the flat map only where it is certainly above the ground and
not far above the vehicle. Lower down, an echo may come from the ground itself; higher up, the beam
passes over what stands on the ground. The ground is level with home.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import numpy.typing as npt

from companion.geometry import NorthEast, body_plane
from companion.motion.position_error import EXACT_HEIGHT_M

REACH_M = 8.0
"""Echoes from farther away are not used: 2 m above the ground, a beam that leans by 11 degrees, the
tilt of an acceleration of 1.9 m/s2, may meet the ground there."""
LEAST_ROOM_M = 0.1
"""The least assumed height of the range finder above the ground, whatever the estimate is."""
MOST_ABOVE_M = 1.5
"""An echo from higher above the vehicle may come from something that is not in its way."""

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RangeScan:
    """Distances all around, with the pose of the vehicle when they were measured.

    Attributes:
        stamp_s: time of reception.
        position: position of the vehicle, in the mission's frame.
        distances_m: (n,) along each beam; inf: nothing within the range; nan: unknown.
        first_rad: direction of the first beam in the plane of the beams; 0 is the heading, positive
            to the right.
        step_rad: angle from one beam to the next; negative to the left.
        range_m: greatest distance that can be measured.
        up_m: altitude of the vehicle above home.
        yaw_rad: heading of the vehicle, 0 is north.
        tilt_rad: roll and pitch of the vehicle.
        height_error_m: how far the vehicle may be below that altitude.
    """

    stamp_s: float
    position: NorthEast
    distances_m: Floats
    first_rad: float
    step_rad: float
    range_m: float
    up_m: float = 0.0
    yaw_rad: float = 0.0
    tilt_rad: tuple[float, float] = (0.0, 0.0)
    height_error_m: float = EXACT_HEIGHT_M

    @property
    def reach_m(self) -> float:
        """The distance up to which its echoes count if no beam leans."""
        return min(self.range_m, REACH_M)

    @cached_property
    def plane(self) -> Floats:
        """(3, 2) the vehicle's forward and right directions, as north, east and down."""
        return np.array(body_plane(*self.tilt_rad, self.yaw_rad)).T

    @property
    def from_level(self) -> Floats:
        """(2, 2) converts a horizontal vector to the one above it in the plane of the beams."""
        (f_n, r_n), (f_e, r_e), _ = self.plane.tolist()
        return np.asarray(np.array(((r_e, -r_n), (-f_e, f_n))) / (f_n * r_e - r_n * f_e))

    @cached_property
    def beams(self) -> Floats:
        """(3, n) unit vectors along each beam, as north, east and down."""
        count = len(self.distances_m)
        return self.plane @ _in_plane(count, self.first_rad, self.step_rad)

    @property
    def _room_m(self) -> float:
        """The least possible height of the vehicle above the ground."""
        return max(self.up_m - self.height_error_m, LEAST_ROOM_M)

    def sight_m(self, toward: NorthEast) -> float:
        """How far over the ground echoes count in a direction, given as a unit vector."""
        down = float(self.plane[2] @ self.from_level @ toward)
        return 1 / max(down / self._room_m, down / -MOST_ABOVE_M, 1 / self.reach_m)

    def reaches_m(self, above_m: float) -> Floats:
        """(n,) how far each beam stays above the ground and not too far above the vehicle.

        Args:
            above_m: how far above the vehicle is too far.
        """
        down = self.beams[2]
        steepness = np.maximum(down / self._room_m, down / -above_m)
        return np.asarray(1 / np.maximum(steepness, 1 / self.reach_m))


@lru_cache(maxsize=8)
def _in_plane(count: int, first_rad: float, step_rad: float) -> Floats:
    """(2, n) each beam's components forward and right."""
    angles = first_rad + step_rad * np.arange(count)
    return np.array((np.cos(angles), np.sin(angles)))


def echoes(scan: RangeScan, behind_m: float = 0.0) -> Floats:
    """(3, n) north, east and down of the points where beams of a scan end, within reach.

    Args:
        scan: the scan.
        behind_m: a distance to add along each beam.
    """
    (ends,) = (scan.distances_m <= scan.reaches_m(MOST_ABOVE_M)).nonzero()  # nan compares as false
    north, east, down = scan.beams[:, ends] * (scan.distances_m[ends] + behind_m)
    return np.array((scan.position[0] + north, scan.position[1] + east, down - scan.up_m))
