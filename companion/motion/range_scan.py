"""Range scans: distances all around, and the points that echoes come from.

A range finder is fixed to its vehicle, and its beams lie in one plane, which leans as the vehicle
leans. So a beam says something of the flat map only where it is above the ground for certain, and
not far above the vehicle: below may be the ground itself, and over what stands there a beam that
looks up has passed. Ground is what is level with home.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import numpy.typing as npt

from companion.geometry import NorthEast, body_plane
from companion.motion.position_error import EXACT_HEIGHT_M

REACH_M = 8.0
"""Echoes from farther away are not used: at 2 m above ground a beam that leans by 11 degrees, the
tilt of an acceleration of 1.9 m/s2, may be at the ground there."""
LEAST_ROOM_M = 0.1
"""However low the vehicle is taken to be, its range finder is so high above the ground."""
MOST_ABOVE_M = 1.5
"""An echo from so far above the vehicle may be of what hangs there, and is in nobody's way."""

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RangeScan:
    """Distances all around, from where the vehicle was when they were measured.

    Attributes:
        stamp_s: time of reception.
        position: of the vehicle, in the mission's frame.
        distances_m: (n,) along each beam; inf: nothing within the range; nan: not known.
        first_rad: direction of the first beam in the plane of all, 0 is that of the heading,
            positive to the right.
        step_rad: angle from one beam to the next; negative to the left.
        range_m: greatest distance that is measured.
        up_m: altitude of the vehicle above home.
        yaw_rad: heading of the vehicle, 0 is north.
        tilt_rad: its roll and pitch.
        height_error_m: how far it may be below that altitude.
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
        """How far its echoes count, where no beam leans."""
        return min(self.range_m, REACH_M)

    @cached_property
    def plane(self) -> Floats:
        """(3, 2) north, east and down of the vehicle's forward and its right."""
        return np.array(body_plane(*self.tilt_rad, self.yaw_rad)).T

    @property
    def from_level(self) -> Floats:
        """(2, 2) makes of a way over the ground, north and east, that in the plane above it."""
        (f_n, r_n), (f_e, r_e), _ = self.plane.tolist()
        return np.asarray(np.array(((r_e, -r_n), (-f_e, f_n))) / (f_n * r_e - r_n * f_e))

    @cached_property
    def beams(self) -> Floats:
        """(3, n) north, east and down along each beam, unit vectors."""
        count = len(self.distances_m)
        return self.plane @ _in_plane(count, self.first_rad, self.step_rad)

    @property
    def _room_m(self) -> float:
        """How high the vehicle is above what may be the ground."""
        return max(self.up_m - self.height_error_m, LEAST_ROOM_M)

    def sight_m(self, toward: NorthEast) -> float:
        """How far over the ground echoes count in a direction, a unit vector."""
        down = float(self.plane[2] @ self.from_level @ toward)
        return 1 / max(down / self._room_m, down / -MOST_ABOVE_M, 1 / self.reach_m)

    def reaches_m(self, above_m: float) -> Floats:
        """(n,) how far along each beam it is above the ground, and not too far above the vehicle.

        Args:
            above_m: how far that is.
        """
        down = self.beams[2]
        steepness = np.maximum(down / self._room_m, down / -above_m)
        return np.asarray(1 / np.maximum(steepness, 1 / self.reach_m))


@lru_cache(maxsize=8)
def _in_plane(count: int, first_rad: float, step_rad: float) -> Floats:
    """(2, n) forward and right along each beam."""
    angles = first_rad + step_rad * np.arange(count)
    return np.array((np.cos(angles), np.sin(angles)))


def echoes(scan: RangeScan, behind_m: float = 0.0) -> Floats:
    """(3, n) north, east and down of the points where beams of a scan end, within reach.

    Args:
        scan: the scan.
        behind_m: so much further along each beam.
    """
    (ends,) = (scan.distances_m <= scan.reaches_m(MOST_ABOVE_M)).nonzero()  # nan is none
    north, east, down = scan.beams[:, ends] * (scan.distances_m[ends] + behind_m)
    return np.array((scan.position[0] + north, scan.position[1] + east, down - scan.up_m))
