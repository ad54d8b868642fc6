"""The vehicle's track and charge for `flight.png`, of limited size even in a flight of days."""

from __future__ import annotations

from dataclasses import dataclass, field

from companion.flight_events.event import Stamped
from companion.flight_events.plans import PlanMade, PlanReplaced, WrittenTreeAdopted
from companion.geometry import Ned
from companion.record.charge_trail import ChargeTrail

PARTS_MAX = 12
"""Number of plans that have a part of their own."""
POSITIONS_MAX = 1024
"""Most positions of a part: 51 s at 20 Hz; in a longer part, every second one is kept, or fewer."""


@dataclass
class Trail:
    """The vehicle's track, in one part per plan; its size is limited.

    Attributes:
        parts: title and positions of each.
        charge: the charge of the battery.
    """

    parts: list[tuple[str, list[Ned]]] = field(default_factory=list)
    charge: ChargeTrail = field(default_factory=ChargeTrail)
    _added: int = 0
    _stride: int = 1

    def take(self, stamped: Stamped) -> None:
        """Takes an event; a plan begins another part."""
        self.charge.take(stamped)
        match stamped.event:
            case PlanMade():
                self.begin("first plan")
            case WrittenTreeAdopted():
                self.begin("the tree that was written by hand")
            case PlanReplaced(number=number, reason=reason):
                self.begin(f"replan {number}: {reason}")

    def begin(self, title: str) -> None:
        """Begins a part; the last possible one gets the rest of the flight."""
        if len(self.parts) == PARTS_MAX:
            first, positions = self.parts[-1]
            suffix = " and all later plans"
            self.parts[-1] = (first.removesuffix(suffix) + suffix, positions)
            return
        self.parts.append((title, []))
        self._added, self._stride = 0, 1

    def add(self, position: Ned) -> None:
        """Adds a position to the present part."""
        if not self.parts:
            return
        positions = self.parts[-1][1]
        if self._added % self._stride == 0:
            positions.append(position)
        self._added += 1
        if len(positions) > POSITIONS_MAX:
            del positions[1::2]
            self._stride *= 2
