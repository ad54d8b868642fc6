"""How often was the vehicle in a circle, and does the target detector see the target?

A visit begins when the vehicle enters the circle. Being there at the start is no entry. A visit
ends once the vehicle is clearly outside, so that a vehicle that holds on the edge does not visit
twice. The detector sees what the scenario's events tell it to see.
"""

from __future__ import annotations

from dataclasses import dataclass

from companion.geometry import Ned, NorthEast, horizontal_distance

LEAVING_MARGIN_M = 0.5


@dataclass(frozen=True, slots=True)
class Circle:
    """A place on the ground."""

    centre: NorthEast
    radius_m: float

    def holds(self, position: Ned) -> bool:
        """Whether a position lies in or above the circle."""
        return horizontal_distance(position, self.centre) <= self.radius_m


class Visits:
    """Counts the visits.

    Args:
        circle: what is visited.
        start: where the vehicle is at first.

    Attributes:
        count: visits begun so far.
    """

    def __init__(self, circle: Circle, start: Ned) -> None:
        self._circle = circle
        self._is_inside = circle.holds(start)
        self.count = 0

    def update(self, position: Ned) -> None:
        """Take the vehicle's position."""
        away_m = horizontal_distance(position, self._circle.centre)
        if not self._is_inside and away_m <= self._circle.radius_m:
            self._is_inside = True
            self.count += 1
        elif away_m > self._circle.radius_m + LEAVING_MARGIN_M:
            self._is_inside = False


@dataclass(slots=True)
class Detector:
    """The target detector.

    Attributes:
        component: its MAVLink component id.
    """

    component: int
    sees_target: bool = False
