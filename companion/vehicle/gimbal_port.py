"""The acting side's interface to gimbals: point one somewhere, learn when it points there.

`gimbals.py` implements the port over MAVLink.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, slots=True)
class Aim:
    """A direction for a gimbal.

    Attributes:
        pitch_rad: up is positive.
        yaw_rad: clockwise, from the vehicle's heading or from north.
        is_from_north: the gimbal keeps the direction when the vehicle turns.
    """

    pitch_rad: float
    yaw_rad: float
    is_from_north: bool


@dataclass(frozen=True, slots=True)
class Aimed:
    """The gimbal points in the direction."""


@dataclass(frozen=True, slots=True)
class NotAimed:
    """The gimbal does not point there; the reason is in words."""

    reason: str


AimOutcome = Aimed | NotAimed | None
"""What became of the request; None while the gimbal turns."""


class Gimbals(Protocol):
    """The gimbals of a vehicle."""

    def point(self, component: int, aim: Aim, timeout_s: float | None) -> int:
        """Begin to point a gimbal; returns a ticket for `outcome`.

        Args:
            component: the gimbal's manager, which may be the autopilot.
            aim: the direction.
            timeout_s: time for the whole procedure; None for the default.
        """

    def outcome(self, ticket: int) -> AimOutcome:
        """What became of the request."""

    def forget(self, ticket: int) -> None:
        """Stop pursuing the request."""
