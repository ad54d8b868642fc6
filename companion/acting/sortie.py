"""One sortie from the ground to the ground: climb, fly the task, land; `phases.py` has the table.

In each tick, safety comes before the work of the phase:

- If the pilot or a failsafe takes the vehicle, the sortie ends at once and nothing more is sent. If
  control may come back, it yields instead, and waits. It also yields while nothing is heard of a
  vehicle in the air, and after the companion was away.
- A vehicle that is armed or flying before we start is left alone.
- A vehicle whose autopilot has weak failsafes is not armed, unless the operator accepts that.

authority.py decides who has control of the vehicle, and when it is handed over again. The operator
can pause a sortie (the vehicle holds, the task is frozen), continue it, call home, and stop it.
"""

from __future__ import annotations

from collections.abc import Sequence

from companion.acting.authority import is_silent, loss_of_control
from companion.acting.beginning import Beginning
from companion.acting.control import Control
from companion.acting.crash_watch import Crash, CrashWatch
from companion.acting.ending import ending, ending_begun, last_resort
from companion.acting.executive import Executive
from companion.acting.flight import Flight
from companion.acting.flight_limit import LimitWatch
from companion.acting.flown_task import FlownTask
from companion.acting.frame_watch import FrameWatch
from companion.acting.gate_watch import GateWatch
from companion.acting.journal import PhaseBegun
from companion.acting.phase_goals import PhaseGoals
from companion.acting.phases import ON_THE_GROUND, TRANSITIONS, UNDER_TASK, SortieEvent
from companion.acting.preflight.ground_checks import GroundChecks
from companion.acting.resumption import Resumption
from companion.acting.sortie_terms import USUAL_TERMS, SortieTerms
from companion.errors import Aborted, CompanionError
from companion.flight_events.event import FlightEvent
from companion.flight_events.sortie import (
    ControlRegained,
    ControlYielded,
    GoalFailed,
    LinkSilent,
    Phase,
    PhaseEntered,
    StopRequested,
    VehicleCrashed,
)
from companion.mission.model import Mission
from companion.mission.signals import Signal
from companion.outcomes import Failed, Progress, Refusal
from companion.vehicle.ports.state import VehicleState

ON_THE_GROUND_BY_PLAN = Refusal(
    "the vehicle is landing or on the ground by its plan; nothing interrupts that"
)


class Sortie:
    """Flies a mission once.

    Attributes:
        phase: what it is doing.
        beginning: waits for the vehicle, and for the first plan.
        failure: why the sortie did not end well; None while it does.

    Args:
        flight: the flight.
        executive: flies the task.
        mission: says where it begins, and what to do when no plan exists.
        terms: what the operator has chosen beforehand.
        may_yield: whether it waits for the operator after somebody else has taken control.
        resumption: the flight that was under way when the companion was cut off; None for none.
    """

    def __init__(
        self,
        flight: Flight,
        executive: Executive,
        mission: Mission,
        terms: SortieTerms = USUAL_TERMS,
        may_yield: bool = False,
        resumption: Resumption | None = None,
    ) -> None:
        self.phase = Phase.WAITING
        self.failure: CompanionError | None = None
        self._flight = flight
        self._executive = executive
        self.beginning = Beginning(flight, executive, mission.home)
        self._ground_checks = GroundChecks(flight, terms.arming, mission, executive)
        self._crash_watch = CrashWatch(flight.profile)
        self._crash: Crash | None = None
        self._gate_watch, self._frame_watch = GateWatch(flight), FrameWatch(flight)
        self._control = Control(flight, may_yield, terms.resumes, resumption)
        self._limit, self._goals = LimitWatch(terms.limit, flight), PhaseGoals(flight)
        self._flown = FlownTask(flight, executive, mission, self._limit)
        self._resumption = resumption
        self._after_offboard = SortieEvent.TASK_GOES_ON
        self._is_stopping = self._was_stopped = False

    @property
    def has_ended(self) -> bool:
        """Whether nothing is left to do."""
        return self.phase is Phase.ENDED

    def step(self, now_s: float, readings: Sequence[tuple[Signal, float]]) -> None:
        """One tick."""
        flight = self._flight
        flight.now_s = now_s
        if self.has_ended:
            return
        if self._is_stopping:
            self._stop()
        self._flown.sense(readings, self.phase)
        self._gate_watch.step()
        state = flight.vehicle.state
        lost = self._frame_watch.step(self.phase)
        if lost is not None and (state is None or self.phase in ON_THE_GROUND):
            self._give_up(lost)
        if state is None or self.has_ended:
            return
        self._control.step(state)
        is_resumed = self.phase is Phase.WAITING and self._resumption is not None
        if self.phase is not Phase.YIELDED and not is_resumed:  # else it is not ours to judge
            if (crash := self._crash_watch.step(now_s, state)) is not self._crash:
                self._take_crash(crash)
                return
            if loss := loss_of_control(self.phase, state, flight):
                self._lose(loss, state)
                return
            if self._is_waited_for(state):
                self._yield(SortieEvent.SILENT, LinkSilent())
                return
            if lost is not None:
                self._land(lost, SortieEvent.FRAME_LOST)
            if flight.vehicle.control.is_doubted or self._frame_watch.is_frozen(self.phase):
                return  # it goes on from here, or is lost
            flight.guidance.brake()
        self._work(state)

    def _work(self, state: VehicleState) -> None:
        """Does the work of the present phase."""
        match self.phase:
            case Phase.WAITING:
                self._begin(state)
            case Phase.CHECKING:
                self._check_autopilot()
            case Phase.TASK | Phase.PAUSED | Phase.RETURNING:
                self._fly()
            case Phase.YIELDED:
                self._await_control(state)
            case _:
                self._pursue_goal(state)

    def pause(self) -> Refusal | None:
        """Holds in the air with the task frozen."""
        if self.phase is Phase.PAUSED:
            return None
        if self.phase not in UNDER_TASK:
            return Refusal(f"no pause while {self.phase.value}")
        if self._flight.progress.is_landed_by_plan:
            return ON_THE_GROUND_BY_PLAN
        self._flown.interrupt()
        self._on(SortieEvent.PAUSED)
        return None

    def resume(self) -> Refusal | None:
        """Continues from here after a pause or a loss of control."""
        if self.phase in (Phase.TASK, Phase.RETURNING):
            return None
        if self.phase is Phase.PAUSED:
            self._on(self._flown.goes_on)
            return None
        if self.phase is not Phase.YIELDED:
            return Refusal(f"nothing to resume while {self.phase.value}")
        if refusal := self._control.not_handed_over():
            return refusal
        if self._after_offboard is SortieEvent.PAUSE_GOES_ON:
            self._after_offboard = self._flown.goes_on  # the operator ends the pause
        self._regain(ControlRegained())
        return None

    def return_home(self) -> Refusal | None:
        """Leaves the task for a flight home and lands."""
        if self.phase in (Phase.RETURNING, Phase.LANDING):
            return None
        if self.phase not in UNDER_TASK:
            return Refusal(f"no return while {self.phase.value}")
        if self._flight.progress.is_landed_by_plan:
            return ON_THE_GROUND_BY_PLAN
        self._flown.call_home()
        self._on(SortieEvent.CALLED_HOME)
        return None

    def stop(self) -> None:
        """Holds, lands and ends from the next step on; on the ground it ends at once.

        It may be called at any time, also by a signal handler in the middle of a step.
        """
        self._is_stopping = True

    def _stop(self) -> None:
        self._is_stopping, self._was_stopped = False, True
        if self.phase in (Phase.HOLDING, Phase.LANDING):
            return
        self._flight.report(StopRequested())
        state = self._flight.vehicle.state
        is_ours = self.phase not in (*ON_THE_GROUND, Phase.YIELDED)
        if is_ours and state is not None and state.heartbeat.is_armed:
            self._executive.stop()
            self._on(SortieEvent.STOPPED_IN_THE_AIR)
        else:
            self._on(SortieEvent.STOPPED)

    def _take_crash(self, crash: Crash | None) -> None:
        """Lands a vehicle that has hit something and still flies; lets go of any other."""
        self._crash = crash
        self._flight.report(VehicleCrashed(str(crash)))
        if crash is Crash.IMPACT:
            self._land(Aborted(str(crash)), SortieEvent.HIT)
        else:
            self._give_up(Aborted(str(crash)))

    def _land(self, failure: Aborted, event: SortieEvent) -> None:
        """Holds and lands, if it does not already."""
        self.failure = failure
        if self.phase not in (Phase.HOLDING, Phase.LANDING):
            self._executive.stop()
            self._on(event)

    def _lose(self, loss: CompanionError, state: VehicleState) -> None:
        """Yields to whoever has taken the vehicle in the air, or ends the sortie."""
        is_taken = self.phase in UNDER_TASK and self._flight.vehicle.control.takeover is not None
        if is_taken and self._control.may_yield and state.is_flying:
            self._yield(SortieEvent.TAKEN_OVER, ControlYielded(str(loss)))
        else:
            self._give_up(loss)

    def _is_waited_for(self, state: VehicleState) -> bool:
        """Whether a vehicle in the air is silent; a landing by the plan continues without us."""
        is_flown = self.phase in UNDER_TASK and not self._flight.progress.is_landed_by_plan
        return is_flown and is_silent(state, self._flight.now_s)

    def _yield(self, event: SortieEvent, news: FlightEvent) -> None:
        """Interrupts the flight, which continues when control comes back."""
        is_paused = self.phase is Phase.PAUSED
        self._flown.interrupt()
        self._on(event, news)
        self._after_offboard = SortieEvent.PAUSE_GOES_ON if is_paused else self._flown.goes_on
        self._flight.vehicle.release()

    def _regain(self, news: FlightEvent) -> None:
        """Takes control again: streams setpoints, and continues what was interrupted."""
        self._flight.vehicle.control.regain()
        self._flight.guidance.forget_setpoint()  # hold where it is, not where it was taken from us
        self._on(SortieEvent.HANDED_BACK, news)

    def _await_control(self, state: VehicleState) -> None:
        """Sends nothing; ends when control is back, or will not come back."""
        outcome = self._control.wait(state)
        if isinstance(outcome, CompanionError):
            self._give_up(outcome)
        elif outcome is not None:
            self._regain(outcome)

    def _begin(self, state: VehicleState) -> None:
        if self._resumption is not None:
            self._find_again(self._resumption, state)
            return
        outcome = self.beginning.tick(state)
        if isinstance(outcome, CompanionError):
            self._give_up(outcome)
        elif outcome is Progress.DONE:
            self._on(SortieEvent.PLANNED)

    def _find_again(self, resumption: Resumption, state: VehicleState) -> None:
        """Continues after the companion was away; sends nothing before control is given back."""
        if why_not := resumption.why_not(state):
            self._give_up(why_not)
            return
        self._after_offboard = resumption.goes_on_with
        if (ending := resumption.journalled.ending) is not None:
            self.failure = self._flown.failure = resumption.failure
            self._flown.resume_ending(ending)
        if self._after_offboard is SortieEvent.RETURN_GOES_ON:
            self._flown.call_home()
        self._flown.is_interrupted = True
        self._limit.begin(resumption.journalled.armed_s)
        if resumption.is_landing(state):
            self._on(SortieEvent.LANDING_GOES_ON)
        else:
            self._on(SortieEvent.FOUND_AGAIN, self._control.found(resumption, state))
            self._flight.vehicle.release()  # from the hold that a flight home begins with

    def _check_autopilot(self) -> None:
        """Proceeds to arming when the autopilot's failsafes are strong, and its fence in force."""
        outcome = self._ground_checks.tick()
        if isinstance(outcome, Failed):
            self._give_up(Aborted(outcome.reason))
        elif outcome is Progress.DONE:
            self._limit.begin(self._flight.now_s)
            self._on(SortieEvent.CHECKED)

    def _pursue_goal(self, state: VehicleState) -> None:
        outcome = self._goals.tick(self.phase)
        if outcome is Progress.DONE:
            is_entered = self.phase is Phase.OFFBOARD
            self._on(self._after_offboard if is_entered else SortieEvent.REACHED)
        elif isinstance(outcome, Failed):
            reason = outcome.reason + last_resort(self.phase, state)
            self.failure = self.failure or Aborted(reason)
            self._flight.report(GoalFailed(reason))
            self._on(SortieEvent.FAILED)

    def _fly(self) -> None:
        flown, is_paused = self._flown, self.phase is Phase.PAUSED
        if (event := flown.tick_paused() if is_paused else flown.tick()) is not None:
            self.failure, self._after_offboard = flown.failure, flown.goes_on
            self._on(event)

    def _on(self, event: SortieEvent, news: FlightEvent | None = None) -> None:
        """Enters the phase to which an event leads; reports the phase, or the news if given."""
        self.phase = TRANSITIONS.next(self.phase, event)
        self._note_phase()
        if self.phase is Phase.ENDED:
            self._flight.vehicle.release()
            is_called_home = self._flown.is_called_home and not self._was_stopped
            at_limit = self._limit.ending()
            how = ending(self.failure, is_called_home, self._flown.is_satisfied, at_limit)
            self._flight.report(how)
        else:
            self._flight.report(news or PhaseEntered(self.phase))

    def _note_phase(self) -> None:
        """Writes into the journal what the phase is, and how the flight is to end."""
        journal, now_s = self._flight.journal, self._flight.now_s
        journal.note(now_s, PhaseBegun(self.phase))
        if self.phase in (Phase.RETURNING, Phase.HOLDING, Phase.LANDING):
            flown = self._flown
            journal.note(now_s, ending_begun(self.failure, flown.called_to, flown.is_satisfied))

    def _give_up(self, failure: CompanionError) -> None:
        self.failure = failure
        self._on(SortieEvent.GIVEN_UP)
