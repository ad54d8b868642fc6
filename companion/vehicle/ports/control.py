"""Who has control of a vehicle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from companion.vehicle.ports.state import Mode


@dataclass(frozen=True, slots=True)
class Takeover:
    """Somebody else has control of the vehicle.

    Attributes:
        mode: the mode that they chose.
        is_failsafe: a failsafe of the autopilot chose it; otherwise it was the pilot.

    >>> print(Takeover(Mode.POSCTL, is_failsafe=False))
    the pilot has control, in POSCTL
    """

    mode: Mode
    is_failsafe: bool

    def __str__(self) -> str:
        who = "a failsafe of the autopilot" if self.is_failsafe else "the pilot"
        return f"{who} has control, in {self.mode.value}"


class VehicleControl(Protocol):
    """Who has control of a vehicle, as far as its autopilot tells."""

    @property
    def takeover(self) -> Takeover | None:
        """Who has taken control from us (the pilot wins); None while it is ours."""

    @property
    def is_doubted(self) -> bool:
        """Whether control may just have been taken from us; nothing is sent until that is
        decided."""

    def regain(self) -> None:
        """Take back control, which the operator has given back after it was lost."""
