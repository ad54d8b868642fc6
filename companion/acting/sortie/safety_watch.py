"""Looks after the vehicle in each tick of a sortie, before the work of the phase.

- A vehicle that is armed or flying before we start is left alone.
- If the pilot or a failsafe takes the vehicle, the sortie ends at once and nothing more is sent. If
  control may come back, it yields instead, and waits. It also yields while nothing is heard of a
  vehicle in the air.
- A vehicle that has hit something and still flies is landed; a crash of another kind ends the
  sortie. A vehicle whose frame is in doubt for too long is landed, too.

authority.py decides who has control of the vehicle.
"""

from __future__ import annotations

from collections.abc import Collection

from companion.acting.flight import Flight
from companion.acting.sortie.authority import is_silent, loss_of_control
from companion.acting.sortie.control import Control
from companion.acting.sortie.crash_watch import Crash, CrashWatch
from companion.acting.sortie.fence_watch import FenceWatch
from companion.acting.sortie.flown_task import FlownTask
from companion.acting.sortie.frame_watch import FrameWatch
from companion.acting.sortie.gate_watch import GateWatch
from companion.acting.sortie.phase_work import PhaseEnd
from companion.acting.sortie.phases import LANDS, ON_THE_GROUND, UNDER_TASK, SortieEvent
from companion.errors import Aborted, CompanionError
from companion.flight_events.event import FlightEvent
from companion.flight_events.sortie import ControlYielded, LinkSilent, Phase, VehicleCrashed
from companion.vehicle.ports.state import VehicleState


class SafetyWatch:
    """The watches of one sortie.

    Args:
        flight: the flight.
        flown: what is interrupted when the vehicle is yielded.
        control: whether it may come back.
        not_ours: the phases in which somebody else flies the vehicle.
    """

    def __init__(
        self, flight: Flight, flown: FlownTask, control: Control, not_ours: Collection[Phase]
    ) -> None:
        self._flight, self._flown, self._control = flight, flown, control
        self._not_ours = not_ours
        self._crash_watch = CrashWatch(flight.profile)
        self._crash: Crash | None = None
        self._gate_watch, self._frame_watch = GateWatch(flight), FrameWatch(flight)
        self._fence_watch = FenceWatch(flight)

    def look(self, phase: Phase, state: VehicleState | None) -> PhaseEnd | None:
        """What ends the phase for the sake of safety; None if nothing does."""
        self._gate_watch.step()
        self._fence_watch.step(phase)
        lost = self._frame_watch.step(phase)
        if lost is not None and (state is None or phase in ON_THE_GROUND):
            return PhaseEnd(SortieEvent.GIVEN_UP, lost)
        if state is None:
            return None
        self._control.step(state)
        if not self.is_ours(phase):
            return None
        if (crash := self._crash_watch.step(self._flight.now_s, state)) is not self._crash:
            self._crash = crash
            return self._crashed(phase, crash)
        if loss := loss_of_control(phase, state, self._flight):
            return self._lost(phase, state, loss)
        if self._is_waited_for(phase, state):
            return self._yielded(phase, SortieEvent.SILENT, LinkSilent())
        return None if lost is None else self._landed(phase, SortieEvent.FRAME_LOST, lost)

    def is_ours(self, phase: Phase) -> bool:
        """Whether nobody else flies the vehicle in a phase."""
        return phase not in self._not_ours

    def is_frozen(self, phase: Phase) -> bool:
        """Whether the work of a phase has to wait; it goes on from here, or is lost."""
        is_doubted = self._flight.vehicle.control.is_doubted
        return self.is_ours(phase) and (is_doubted or self._frame_watch.is_frozen(phase))

    def _crashed(self, phase: Phase, crash: Crash | None) -> PhaseEnd:
        """Lands a vehicle that has hit something and still flies; lets go of any other."""
        self._flight.report(VehicleCrashed(str(crash)))
        failure = Aborted(str(crash))
        if crash is Crash.IMPACT:
            return self._landed(phase, SortieEvent.HIT, failure)
        return PhaseEnd(SortieEvent.GIVEN_UP, failure)

    def _landed(self, phase: Phase, event: SortieEvent, failure: Aborted) -> PhaseEnd:
        """Holds and lands, if it does not already."""
        if phase not in LANDS:
            self._flown.end()
        return PhaseEnd(event, failure)

    def _lost(self, phase: Phase, state: VehicleState, loss: CompanionError) -> PhaseEnd:
        """Yields to whoever has taken the vehicle in the air, or ends the sortie."""
        is_taken = phase in UNDER_TASK and self._flight.vehicle.control.takeover is not None
        if is_taken and self._control.may_yield and state.is_flying:
            return self._yielded(phase, SortieEvent.TAKEN_OVER, ControlYielded(str(loss)))
        return PhaseEnd(SortieEvent.GIVEN_UP, loss)

    def _is_waited_for(self, phase: Phase, state: VehicleState) -> bool:
        """Whether a vehicle in the air is silent; a landing by the plan continues without us."""
        is_flown = phase in UNDER_TASK and not self._flight.progress.is_landed_by_plan
        return is_flown and is_silent(state, self._flight.now_s)

    def _yielded(self, phase: Phase, event: SortieEvent, news: FlightEvent) -> PhaseEnd:
        """Interrupts the flight, which continues when control comes back."""
        self._flown.interrupt(phase)
        return PhaseEnd(event, news=news)
