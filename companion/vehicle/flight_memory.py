"""What a companion remembers of earlier flights, including those of other runs of the program."""

from __future__ import annotations

from dataclasses import dataclass, field

from companion.vehicle.laid_frames import LaidFrames
from companion.vehicle.own_uploads import OwnItems


@dataclass(frozen=True, slots=True)
class FlightMemory:
    """What is remembered.

    Attributes:
        fences, rally_points: those that were written to autopilots.
        frames: where missions' frames were laid; None if that cannot be remembered.
    """

    fences: OwnItems = field(default_factory=OwnItems)
    rally_points: OwnItems = field(default_factory=OwnItems)
    frames: LaidFrames | None = None
