"""Setpoints of a vehicle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from companion.geofence import KeptFence
from companion.geometry import Ned
from companion.outcomes import Refusal


@dataclass(frozen=True, slots=True)
class Setpoint:
    """Where to be, how fast to move there, and how the speed changes.

    Attributes:
        velocity, acceleration: fed forward, so that the vehicle does not lag behind.
        yaw_rad: the heading to hold.
    """

    position: Ned
    velocity: Ned
    acceleration: Ned
    yaw_rad: float


def hold_at(position: Ned, yaw_rad: float) -> Setpoint:
    """The setpoint of a vehicle that stays where it is."""
    return Setpoint(position, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), yaw_rad)


class Setpoints(Protocol):
    """The setpoints of a vehicle, and the gate that they pass."""

    @property
    def refusal(self) -> Refusal | None:
        """Why a hold is sent in place of the setpoint; None if none is."""

    def fly(
        self, setpoint: Setpoint, *, is_for_task: bool = False, is_landing: bool = False
    ) -> None:
        """Stream a setpoint from now on.

        The flags say whether it belongs to the task's plan, and to the descent to a marker or the
        climb from it.
        """

    def keep_within(self, fence: KeptFence) -> None:
        """Refuse every setpoint outside a fence from now on."""
