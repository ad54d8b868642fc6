"""Landing markers that a vehicle sees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from companion.geometry import Ned
from companion.outcomes import Refusal


@dataclass(frozen=True, slots=True)
class MarkerSighting:
    """One sighting of a landing marker.

    Attributes:
        seen_s: when it was seen.
        component: the component that saw it.
        number: the number on the marker.
        position: of the marker, in the mission's frame.
    """

    seen_s: float
    component: int
    number: int
    position: Ned


class Markers(Protocol):
    """Sightings of landing markers."""

    @property
    def seen(self) -> Sequence[MarkerSighting]:
        """Sightings since the previous tick, in order."""

    @property
    def refused(self) -> Sequence[Refusal]:
        """Why others were refused in the same time."""
