"""What the companion does when no plan exists, as values; safe_places.py reads it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

PATIENCE_S = 60.0
"""How long a vehicle without a plan holds, unless the mission says otherwise."""


class Otherwise(Enum):
    """What the companion does when no plan exists."""

    RETURN_HOME = "return_home"
    LAND = "land"
    HOLD = "hold"


@dataclass(frozen=True, slots=True)
class LandAtSafePlace:
    """When no plan exists, the vehicle lands at whichever of these places it reaches soonest.

    >>> print(LandAtSafePlace(("Home", "North", "South")))
    Home, North or South
    """

    places: tuple[str, ...]

    def __str__(self) -> str:
        *others, last = self.places
        return f"{', '.join(others)} or {last}" if others else last
