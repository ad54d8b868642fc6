"""One sortie from the ground to the ground: climb, fly the task, land; `phases.py` has the table.

In each tick, what is asked and what safety demands come before the work of the phase:

    operator_requests.py   pause, continue, home, stop
    safety_watch.py        a pilot or a failsafe, silence, a crash, a frame in doubt
    the phase              a class for each: beginning.py, found_flight.py, ground_checks.py,
                           goal_phases.py, flying_phases.py, control.py

Each of them only says what has ended the phase. The sortie enters the next one, and reports it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import Enum, auto

from companion.acting.assembly import ActingParts
from companion.acting.journal import PhaseBegun
from companion.acting.sortie.beginning import Beginning
from companion.acting.sortie.control import Control
from companion.acting.sortie.ending import ending, ending_begun
from companion.acting.sortie.flight_limit import LimitWatch
from companion.acting.sortie.flown_task import FlownTask
from companion.acting.sortie.flying_phases import FlyingHome, FlyingTask, Paused
from companion.acting.sortie.found_flight import FoundFlight
from companion.acting.sortie.goal_phases import (
    Arming,
    EnteringOffboard,
    Holding,
    Landing,
    Parting,
    TakingOff,
)
from companion.acting.sortie.operator_requests import OperatorRequests
from companion.acting.sortie.phase_work import PhaseEnd, PhaseWork
from companion.acting.sortie.phases import LANDS, TRANSITIONS, SortieEvent
from companion.acting.sortie.preflight.ground_checks import GroundChecks
from companion.acting.sortie.resumption import Resumption
from companion.acting.sortie.safety_watch import SafetyWatch
from companion.acting.sortie.terms import USUAL_TERMS, SortieTerms
from companion.errors import CompanionError
from companion.flight_events.sortie import Phase, PhaseEntered
from companion.mission.model import Mission
from companion.mission.signals import Signal
from companion.outcomes import Refusal

CONSEQUENCES = (SortieEvent.FAILED, SortieEvent.NO_WAY_HOME)
"""Events whose failure counts only if there was none before, of which it may be a consequence."""


class StopRequest(Enum):
    """What has become of the request to stop."""

    NOT_ASKED = auto()
    ASKED = auto()
    FOLLOWED = auto()


class Sortie:
    """Flies a mission once.

    Attributes:
        phase: what it is doing.
        beginning: waits for the vehicle, and for the first plan.
        failure: why the sortie did not end well; None while it does.

    Args:
        acting: the parts that fly the task.
        mission: says where it begins, and what to do when no plan exists.
        terms: what the operator has chosen beforehand.
        may_yield: whether it waits for the operator after somebody else has taken control.
        resumption: the flight that was under way when the companion was cut off; None for none.
    """

    def __init__(
        self,
        acting: ActingParts,
        mission: Mission,
        terms: SortieTerms = USUAL_TERMS,
        may_yield: bool = False,
        resumption: Resumption | None = None,
    ) -> None:
        flight, executive = acting.flight, acting.executive
        self.phase = Phase.WAITING
        self.failure: CompanionError | None = None
        self.beginning = Beginning(flight, executive, mission.home)
        self._flight, self._perception = flight, acting.perception
        self._limit = limit = LimitWatch(terms.limit, flight)
        self._flown = flown = FlownTask(flight, executive, mission)
        self._stop_request = StopRequest.NOT_ASKED
        control = Control(flight, may_yield, terms.resumes, resumption)
        self._requests = OperatorRequests(flight, flown, control)
        self._work: Mapping[Phase, PhaseWork] = {
            Phase.WAITING: FoundFlight(resumption, flown, limit, control)
            if resumption
            else self.beginning,
            Phase.CHECKING: GroundChecks(flight, terms.arming, mission, executive, limit),
            Phase.ARMING: Arming(flight),
            Phase.TAKE_OFF: TakingOff(flight),
            Phase.OFFBOARD: EnteringOffboard(flight, flown),
            Phase.TASK: FlyingTask(flight, executive, flown, limit),
            Phase.PAUSED: Paused(flight, executive, flown),
            Phase.RETURNING: FlyingHome(flight, flown, limit),
            Phase.YIELDED: control,
            Phase.HOLDING: Holding(flight),
            Phase.PARTING: Parting(flight),
            Phase.LANDING: Landing(flight),
        }
        not_ours = (Phase.YIELDED, Phase.WAITING) if resumption else (Phase.YIELDED,)
        self._safety = SafetyWatch(flight, flown, control, not_ours)

    @property
    def has_ended(self) -> bool:
        """Whether nothing is left to do."""
        return self.phase is Phase.ENDED

    def step(self, now_s: float, readings: Sequence[tuple[Signal, float]]) -> None:
        """One tick."""
        self._flight.now_s = now_s
        if self._stop_request is StopRequest.ASKED and not self.has_ended:
            self._stop_request = StopRequest.FOLLOWED
            self._end_phase(self._requests.stop(self.phase))
        if self.has_ended:
            return
        self._flown.pass_time(self.phase)  # before the events: one that comes just then is late
        self._perception.take(readings)
        state = self._flight.vehicle.state
        end = self._safety.look(self.phase, state)
        if end is None and state is not None and not self._safety.is_frozen(self.phase):
            if self._safety.is_ours(self.phase):
                self._flight.guidance.brake()
            end = self._work[self.phase].tick(state)
        self._end_phase(end)

    def pause(self) -> Refusal | None:
        """Holds in the air with the task frozen."""
        return self._answer(self._requests.pause(self.phase))

    def resume(self) -> Refusal | None:
        """Continues from here after a pause or a loss of control."""
        return self._answer(self._requests.resume(self.phase))

    def return_home(self) -> Refusal | None:
        """Leaves the task for a flight home and lands."""
        return self._answer(self._requests.return_home(self.phase))

    def stop(self) -> None:
        """Holds, lands and ends from the next step on; on the ground it ends at once.

        It may be called at any time, also by a signal handler in the middle of a step.
        """
        if self._stop_request is StopRequest.NOT_ASKED:
            self._stop_request = StopRequest.ASKED

    def _answer(self, granted: PhaseEnd | Refusal | None) -> Refusal | None:
        if isinstance(granted, Refusal):
            return granted
        self._end_phase(granted)
        return None

    def _end_phase(self, end: PhaseEnd | None) -> None:
        """Enters the next phase, and reports it, or the news if there are any."""
        if end is None:
            return
        if self.failure is None or end.event not in CONSEQUENCES:
            self.failure = end.failure or self.failure
        if end.event is SortieEvent.HIT and self.phase in LANDS:
            self._note_phase()
            return
        self.phase = TRANSITIONS.next(self.phase, end.event)
        self._note_phase()
        if self.phase in (Phase.YIELDED, Phase.ENDED):
            self._flight.vehicle.release()
        if self.phase is not Phase.ENDED:
            self._flight.report(end.news or PhaseEntered(self.phase))
            return
        flown = self._flown
        is_called_home = flown.is_called_home and self._stop_request is not StopRequest.FOLLOWED
        at_limit = self._limit.ending()
        self._flight.report(ending(self.failure, is_called_home, flown.is_satisfied, at_limit))

    def _note_phase(self) -> None:
        """Writes into the journal what the phase is, and how the flight is to end."""
        journal, now_s = self._flight.journal, self._flight.now_s
        journal.note(now_s, PhaseBegun(self.phase))
        if self.phase in (Phase.RETURNING, Phase.HOLDING, Phase.LANDING):
            flown = self._flown
            journal.note(now_s, ending_begun(self.failure, flown.called_to, flown.is_satisfied))
