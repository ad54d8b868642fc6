"""Circles on the ground, and how often the vehicle has visited each.

A visit begins when the vehicle enters the circle; a start inside is no visit. A visit ends once the
vehicle is clearly outside, so a vehicle that holds at the edge is not counted twice.
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
        """Whether a position lies in or above the circle, edge included."""
        return horizontal_distance(position, self.centre) <= self.radius_m


class VisitCounter:
    """Counts the visits to a circle.

    Args:
        circle: the place to visit.
        start: first position of the vehicle.

    Attributes:
        count: how many visits have begun.
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
