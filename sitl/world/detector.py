"""Does the target detector see the target?

It does from the moment when the vehicle enters a circle for the n-th time. Being there at the
start is no entry. A visit ends once the vehicle is clearly outside, so that a vehicle that holds
on the edge does not visit twice.
"""

from __future__ import annotations

from dataclasses import dataclass

from companion.geometry import Ned, NorthEast, horizontal_distance

LEAVING_MARGIN_M = 0.5


@dataclass(frozen=True, slots=True)
class Sighting:
    """Where and when the target is seen.

    Attributes:
        component: MAVLink component id of the detector.
        centre: of the circle.
        visit: which entry into the circle shows the target, from 1.
    """

    component: int
    centre: NorthEast
    radius_m: float
    visit: int


class Detector:
    """Counts the visits.

    Args:
        sighting: what to wait for.
        start: where the vehicle is at first.
    """

    def __init__(self, sighting: Sighting, start: Ned) -> None:
        self.sighting = sighting
        self._visits = 0
        self._is_inside = horizontal_distance(start, sighting.centre) <= sighting.radius_m

    @property
    def sees_target(self) -> bool:
        """The target has been found."""
        return self._visits >= self.sighting.visit

    def update(self, position: Ned) -> None:
        """Take the vehicle's position."""
        away_m = horizontal_distance(position, self.sighting.centre)
        if not self._is_inside and away_m <= self.sighting.radius_m:
            self._is_inside = True
            self._visits += 1
        elif away_m > self.sighting.radius_m + LEAVING_MARGIN_M:
            self._is_inside = False
