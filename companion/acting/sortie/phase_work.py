"""What the phases of a sortie have in common: work in each tick, until something ends the phase."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from companion.acting.sortie.phases import SortieEvent
from companion.errors import CompanionError
from companion.flight_events.event import FlightEvent
from companion.vehicle.ports.state import VehicleState


@dataclass(frozen=True, slots=True)
class PhaseEnd:
    """What ends a phase.

    Attributes:
        event: what has happened; the table says which phase follows.
        failure: why the sortie does not end well from now on; None if this is no reason.
        news: what is reported instead of the next phase; None for the phase itself.
    """

    event: SortieEvent
    failure: CompanionError | None = None
    news: FlightEvent | None = None


class PhaseWork(Protocol):
    """The work of one phase."""

    def tick(self, state: VehicleState) -> PhaseEnd | None:
        """One tick; returns what ends the phase, or None while it lasts."""
