"""Where the frame of a mission lies."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from companion.geometry import GlobalOrigin, Ned
from companion.outcomes import Refusal


class Anchoring(Enum):
    """What determines where the origin of the mission's frame, and so home, is."""

    BY_VEHICLE = "where the vehicle stands when its first sortie begins"
    FIXED = "the mission, or an earlier sortie of this program"
    RECALLED = "the earlier flights of another program"


@dataclass(frozen=True, slots=True)
class FrameLocation:
    """Where the frames are on the earth.

    Attributes:
        origin: that of the autopilot's local frame.
        zero: the origin of the mission's frame.
        is_asked_for: the mission gives its origin; otherwise it is where the vehicle began.
        residual_m: distance between the autopilot's local and global reports of its position.
    """

    origin: GlobalOrigin
    zero: GlobalOrigin
    is_asked_for: bool
    residual_m: float


class PlacedFrame(Protocol):
    """Where the frame of the mission is, by what the autopilot says."""

    @property
    def doubt(self) -> Refusal | None:
        """Why the position in the mission's frame is unknown or uncertain; None if it is
        certain."""

    @property
    def origin(self) -> GlobalOrigin | None:
        """Where the autopilot's local frame is on the earth; None while frames are not known."""

    @property
    def location(self) -> FrameLocation | None:
        """Where the frames are on the earth; None if not known."""

    @property
    def anchoring(self) -> Anchoring:
        """What determines where home is."""

    @property
    def is_settling(self) -> bool:
        """Whether the position of the standing vehicle is being averaged."""

    def gap_m(self, place: Ned, accuracy_m: float) -> float | None:
        """How far from a place the vehicle stands on the ground; None until that is certain.

        Args:
            place: in the mission's frame.
            accuracy_m: of the vehicle's position.
        """

    def stand_at(self, place: Ned) -> None:
        """Declare that the vehicle stands at a place, from where the mission's map is valid."""
