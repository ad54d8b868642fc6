"""How far a plan has come, and whether it has the vehicle in the air or on the ground.

1. A plan begins in the air. A vehicle that is on the ground takes off first (`sortie.py`).
2. While the plan has the vehicle on the ground, nothing interrupts the plan, and a disarmed vehicle
   is no loss of control.
3. A run ends in DISARMED or LANDING_UNNOTICED: the vehicle is left to whoever stopped it, or to its
   autopilot (`authority.py`).
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from companion.outcomes import Failed
from companion.planning.domain import Action


class GroundState(Enum):
    """Where the plan has the vehicle."""

    IN_AIR = "in the air"
    DESCENDING = "in the air, on its way down to the marker of its place"
    ON_GROUND = "on the ground; or it lands or takes off"
    STRANDED = "on the ground, where an action has failed"
    DISARMED = "on the ground, disarmed in a take-off by somebody else or by a crash"
    LANDING_UNNOTICED = "the autopilot lands, and does not say that it has landed"


@dataclass
class PlanProgress:
    """How far a plan has come. Each plan has its own; the nodes of its tree write it.

    Attributes:
        completed: number of completed skills; `Effects` counts them.
        laps: number of laps of the loop; `Effects` counts them.
        ground: where the plan has the vehicle.
        failed: the skill whose failure has ended the plan; None if none has.
        flight_ends_s: when the flight under way ends if nothing slows it down from now on; None if
            its route has not begun.
        unnoticed_landing: why the last landing has failed, in LANDING_UNNOTICED; else None.
    """

    completed: int = 0
    laps: int = 0
    ground: GroundState = GroundState.IN_AIR
    failed: Action | None = None
    flight_ends_s: float | None = None
    unnoticed_landing: Failed | None = None

    @property
    def is_landed_by_plan(self) -> bool:
        """Whether the plan has the vehicle on the ground, and may not be interrupted."""
        return self.ground not in (GroundState.IN_AIR, GroundState.DESCENDING)

    def begin_descent(self) -> None:
        """Notes that the vehicle descends to a marker, unless it is on the ground already."""
        if not self.is_landed_by_plan:
            self.ground = GroundState.DESCENDING

    def end_descent(self) -> None:
        """Notes that a descent has ended in the air; one that has ended on the ground stays so."""
        if self.ground is GroundState.DESCENDING:
            self.ground = GroundState.IN_AIR

    def take_to_ground(self) -> None:
        """Notes that the plan lands the vehicle or takes off, and may no longer be interrupted."""
        self.ground = GroundState.ON_GROUND

    def leave_ground(self) -> None:
        """Notes that the vehicle is in the air, by the plan or because somebody took it there."""
        if self.is_landed_by_plan:
            self.ground = GroundState.IN_AIR

    def strand(self) -> None:
        """Notes that an action has failed, so that a plan on the ground cannot go on from there."""
        if self.ground is GroundState.ON_GROUND:
            self.ground = GroundState.STRANDED

    def miss_landing(self, failed: Failed) -> None:
        """Notes that the autopilot lands, and does not say that it has landed."""
        self.ground, self.unnoticed_landing = GroundState.LANDING_UNNOTICED, failed
