"""The beginning of a sortie after the companion was away: its vehicle may still fly.

Nothing is sent before control is given back.
"""

from __future__ import annotations

from companion.acting.sortie.control import Control
from companion.acting.sortie.flight_limit import LimitWatch
from companion.acting.sortie.flown_task import FlownTask
from companion.acting.sortie.phase_work import PhaseEnd
from companion.acting.sortie.phases import SortieEvent
from companion.acting.sortie.resumption import Resumption
from companion.vehicle.ports.state import VehicleState


class FoundFlight:
    """Continues a flight in its first tick.

    Args:
        resumption: the flight that was under way when the companion was cut off.
        flown: continues what was flown.
        limit: the limit of the flight, which counts from its own beginning.
        control: says what gives control back.
    """

    def __init__(
        self, resumption: Resumption, flown: FlownTask, limit: LimitWatch, control: Control
    ) -> None:
        self._resumption, self._flown = resumption, flown
        self._limit, self._control = limit, control

    def tick(self, state: VehicleState) -> PhaseEnd:
        """Says how the flight continues, or why it does not."""
        resumption = self._resumption
        if why_not := resumption.why_not(state):
            return PhaseEnd(SortieEvent.GIVEN_UP, why_not)
        self._flown.continue_with(resumption.goes_on_with, resumption.journalled.ending)
        self._limit.begin(resumption.journalled.armed_s)
        if resumption.is_landing(state):
            return PhaseEnd(SortieEvent.LANDING_GOES_ON, resumption.failure)
        news = self._control.found(resumption, state)
        return PhaseEnd(SortieEvent.FOUND_AGAIN, resumption.failure, news)
