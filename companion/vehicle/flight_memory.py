"""What a companion remembers of earlier flights, of other programs too."""

from __future__ import annotations

from dataclasses import dataclass, field

from companion.vehicle.laid_frames import LaidFrames
from companion.vehicle.own_uploads import OwnItems


@dataclass(frozen=True, slots=True)
class FlightMemory:
    """What is remembered.

    Attributes:
        fences, rally_points: what was written to autopilots.
        frames: where missions begin; None where that cannot be remembered.
    """

    fences: OwnItems = field(default_factory=OwnItems)
    rally_points: OwnItems = field(default_factory=OwnItems)
    frames: LaidFrames | None = None
