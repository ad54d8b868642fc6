"""What the acting side knows of gimbals: they are pointed somewhere, and say when they are there.

`gimbals.py` fulfils the port over MAVLink.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, slots=True)
class Aim:
    """Where a gimbal points to.

    Attributes:
        pitch_rad: up is positive.
        yaw_rad: clockwise, from the vehicle's heading or from north.
        is_from_north: it keeps the direction when the vehicle turns.
    """

    pitch_rad: float
    yaw_rad: float
    is_from_north: bool


@dataclass(frozen=True, slots=True)
class Aimed:
    """The gimbal points there."""


@dataclass(frozen=True, slots=True)
class NotAimed:
    """It does not, for a reason in words."""

    reason: str


AimOutcome = Aimed | NotAimed | None
"""What has become of it; None while it turns."""


class Gimbals(Protocol):
    """The gimbals of a vehicle."""

    def point(self, component: int, aim: Aim, timeout_s: float | None) -> int:
        """Begin to point a gimbal; returns a ticket for `outcome`.

        Args:
            component: its manager, which may be the autopilot.
            aim: where to.
            timeout_s: time for all of it; None for the usual one.
        """

    def outcome(self, ticket: int) -> AimOutcome:
        """What has become of it."""

    def forget(self, ticket: int) -> None:
        """Ask for it no longer."""
