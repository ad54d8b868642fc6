"""Circles on the ground, and how often the vehicle has visited one.

A visit begins when the vehicle enters the circle. Being there at the start is no entry. A visit
ends once the vehicle is clearly outside, so that a vehicle that holds on the edge does not visit
twice.
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

    def contains(self, position: Ned) -> bool:
        """True if a position lies in or above the circle, its edge included."""
        return horizontal_distance(position, self.centre) <= self.radius_m


class VisitCounter:
    """Counts the visits to a circle.

    Args:
        circle: what is visited.
        start: where the vehicle is at first.

    Attributes:
        count: visits begun so far.
    """

    def __init__(self, circle: Circle, start: Ned) -> None:
        self._circle = circle
        self._is_inside = circle.contains(start)
        self.count = 0

    def update(self, position: Ned) -> None:
        """Takes the vehicle's position."""
        away_m = horizontal_distance(position, self._circle.centre)
        if not self._is_inside and away_m <= self._circle.radius_m:
            self._is_inside = True
            self.count += 1
        elif away_m > self._circle.radius_m + LEAVING_MARGIN_M:
            self._is_inside = False
