"""What operators may ask for in each phase: pause, continue, fly home, stop."""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.acting.sortie.control import Control
from companion.acting.sortie.flown_task import FlownTask
from companion.acting.sortie.phase_work import PhaseEnd
from companion.acting.sortie.phases import LANDS, ON_THE_GROUND, UNDER_TASK, SortieEvent
from companion.flight_events.sortie import ControlRegained, Phase, StopRequested
from companion.outcomes import Refusal

ON_THE_GROUND_BY_PLAN = Refusal(
    "the vehicle is landing or on the ground by its plan; nothing interrupts that"
)


class OperatorRequests:
    """Grants or refuses what is asked for; None if the sortie does that already.

    Args:
        flight: the flight.
        flown: what is paused, continued or left.
        control: whether it may be given back.
    """

    def __init__(self, flight: Flight, flown: FlownTask, control: Control) -> None:
        self._flight, self._flown, self._control = flight, flown, control

    def pause(self, phase: Phase) -> PhaseEnd | Refusal | None:
        """Holds in the air with the task frozen."""
        if phase is Phase.PAUSED:
            return None
        if refusal := self._not_interrupted(phase, "pause"):
            return refusal
        self._flown.interrupt(phase)
        return PhaseEnd(SortieEvent.PAUSED)

    def resume(self, phase: Phase) -> PhaseEnd | Refusal | None:
        """Continues from here after a pause or a loss of control."""
        match phase:
            case Phase.TASK | Phase.RETURNING:
                return None
            case Phase.PAUSED:
                return PhaseEnd(self._flown.end_pause())
            case Phase.YIELDED:
                if refusal := self._control.not_handed_over():
                    return refusal
                if self._flown.goes_on is SortieEvent.PAUSE_GOES_ON:
                    self._flown.end_pause()
                return self._control.take_back(ControlRegained())
        return Refusal(f"nothing to resume while {phase.value}")

    def return_home(self, phase: Phase) -> PhaseEnd | Refusal | None:
        """Leaves the task for a flight home and lands."""
        if phase in (Phase.RETURNING, Phase.LANDING):
            return None
        if refusal := self._not_interrupted(phase, "return"):
            return refusal
        self._flown.call_home()
        return PhaseEnd(SortieEvent.CALLED_HOME)

    def stop(self, phase: Phase) -> PhaseEnd | None:
        """Holds, lands and ends; on the ground, or if the vehicle is not ours, ends at once."""
        if phase in LANDS:
            return None
        self._flight.report(StopRequested())
        state = self._flight.vehicle.state
        is_ours = phase not in (*ON_THE_GROUND, Phase.YIELDED)
        if not is_ours or state is None or not state.heartbeat.is_armed:
            return PhaseEnd(SortieEvent.STOPPED)
        self._flown.end()
        return PhaseEnd(SortieEvent.STOPPED_IN_THE_AIR)

    def _not_interrupted(self, phase: Phase, what: str) -> Refusal | None:
        """Why the flight is not interrupted in a phase; None if it may be."""
        if phase not in UNDER_TASK:
            return Refusal(f"no {what} while {phase.value}")
        return ON_THE_GROUND_BY_PLAN if self._flight.progress.is_landed_by_plan else None
