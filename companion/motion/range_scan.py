"""Range scans: distances all around, and the points that echoes come from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from companion.geometry import NorthEast

REACH_M = 8.0
"""Echoes from farther away are not used: at 2 m above ground a beam that is tilted by 14 degrees,
the tilt of an acceleration of 2.5 m/s2, meets the ground there."""

Floats = npt.NDArray[np.float64]


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
        up_m: altitude of the vehicle above home.
    """

    stamp_s: float
    position: NorthEast
    distances_m: Floats
    first_rad: float
    step_rad: float
    range_m: float
    up_m: float = 0.0

    @property
    def reach_m(self) -> float:
        """How far its echoes count."""
        return min(self.range_m, REACH_M)


def echoes(scan: RangeScan, reach_m: float, behind_m: float = 0.0) -> Floats:
    """(n, 2) north-east points where the beams of a scan end, within reach.

    Args:
        scan: the scan.
        reach_m: beams that get further are left out.
        behind_m: so much further along each beam.
    """
    (beams,) = np.nonzero(scan.distances_m <= reach_m)  # nan is none
    angles = scan.first_rad + scan.step_rad * beams
    ends_m = scan.distances_m[beams] + behind_m
    ends = np.empty((len(beams), 2))
    ends[:, 0] = scan.position[0] + ends_m * np.cos(angles)
    ends[:, 1] = scan.position[1] + ends_m * np.sin(angles)
    return ends
