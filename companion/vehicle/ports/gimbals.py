"""The acting side's interface to gimbals: point one somewhere, learn when it points there.

`gimbals.py` implements the port over MAVLink.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from companion.outcomes import Outcome


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


class Gimbals(Protocol):
    """The gimbals of a vehicle."""

    def point(self, component: int, aim: Aim, timeout_s: float | None) -> int:
        """Begin to point a gimbal; returns a ticket for `outcome`.

        Args:
            component: the gimbal's manager, which may be the autopilot.
            aim: the direction.
            timeout_s: time for the whole procedure; None for the default.
        """

    def outcome(self, ticket: int) -> Outcome:
        """What became of the request."""

    def forget(self, ticket: int) -> None:
        """Stop pursuing the request."""
