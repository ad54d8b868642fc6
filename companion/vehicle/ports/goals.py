"""Goals of a vehicle."""

from __future__ import annotations

from enum import StrEnum
from typing import Protocol

from companion.outcomes import Outcome


class Goal(StrEnum):
    """A state of the vehicle to bring about; it is reached when it is observed."""

    ARMED = "armed"
    AIRBORNE = "airborne"
    OFFBOARD = "in OFFBOARD"
    HOLDING = "holding"
    LANDED = "landed and disarmed"


class VehicleGoals(Protocol):
    """Brings about goals of a vehicle, one at a time."""

    @property
    def has_restarted(self) -> bool:
        """Whether the autopilot has restarted since the first goal."""

    def pursue(self, goal: Goal, takeoff_up_m: float | None = None) -> Outcome:
        """Work towards a goal; call it every tick while the outcome is RUNNING.

        A take-off leads to `takeoff_up_m` above home; None stands for the mission's own altitude.
        """
