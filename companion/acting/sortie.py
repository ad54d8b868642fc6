"""One sortie from the ground to the ground: climb, fly the task, land; `phases.py` has the table.

Safety comes before the phase: who takes the vehicle from us (pilot or failsafe) ends the sortie at
once and nothing more is sent; or, where an operator may give control back, the sortie yields and
waits for that. A vehicle that is armed or flying before we start is not ours to take, and one whose
autopilot would not look after itself is not armed unless the operator accepts that. A stop that the
operator asked for holds, lands, and ends.

The operator may also pause (hold in the air, the task frozen), let it go on, and call it home.
Whose the vehicle is, and when it is handed over again, is asked in authority.py.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from companion.acting.authority import loss_of_control, loss_of_link, not_at_home, not_handed_over
from companion.acting.crash_watch import Crash, CrashWatch
from companion.acting.ending import ending, last_resort
from companion.acting.executive import Executive
from companion.acting.executive_states import TaskStatus
from companion.acting.failsafe_check import FailsafeCheck
from companion.acting.flight import Flight
from companion.acting.flight_limit import NO_LIMIT, FlightLimit, LimitWatch
from companion.acting.phases import GOALS, ON_THE_GROUND, TRANSITIONS, UNDER_TASK, SortieEvent
from companion.acting.return_home import ReturnHome
from companion.errors import Aborted, CompanionError
from companion.flight_events.event import FlightEvent
from companion.flight_events.sortie import (
    ControlRegained,
    ControlYielded,
    FlightLimitReached,
    GoalFailed,
    Phase,
    PhaseEntered,
    ReturnBegun,
    ReturnFailed,
    SetpointRefused,
    StopRequested,
    VehicleCrashed,
)
from companion.mission.model import Otherwise, Place, Signal
from companion.outcomes import Refusal
from companion.vehicle.port import Failed, Progress, VehicleState

ON_THE_GROUND_BY_PLAN = Refusal(
    "the vehicle is landing or on the ground by its plan; nothing interrupts that"
)


class Sortie:
    """Flies a mission once.

    Attributes:
        phase: where it is.
        failure: why the sortie did not end well; None while it does.

    Args:
        flight: the flight.
        executive: acts out the task.
        home: where the vehicle has to stand at the start.
        otherwise: what to do when no plan exists.
        accepts_weak_failsafes: fly although the autopilot's failsafes are weak.
        may_yield: wait for the operator when somebody else has taken control in flight.
        limit: after what the vehicle is called home.
    """

    def __init__(
        self,
        flight: Flight,
        executive: Executive,
        home: Place,
        otherwise: Otherwise,
        accepts_weak_failsafes: bool = False,
        may_yield: bool = False,
        limit: FlightLimit = NO_LIMIT,
    ) -> None:
        self.phase = Phase.WAITING
        self.failure: CompanionError | None = None
        self._flight = flight
        self._executive = executive
        self._home = home
        self._otherwise = otherwise
        self._failsafes = FailsafeCheck(flight, accepts_weak_failsafes)
        self._crash_watch = CrashWatch(flight.profile)
        self._crash: Crash | None = None
        self._may_yield = may_yield
        self._limit = LimitWatch(limit, executive, flight)
        self._return_home: ReturnHome | None = None
        self._is_frozen = False
        self._is_stopping = self._was_stopped = False
        self._was_refused = False

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
        self._executive.sense(readings)
        self._watch_gate()
        state = flight.vehicle.state
        if state is None or self.has_ended:
            return
        if self.phase is not Phase.YIELDED:  # what a pilot does is not ours to judge
            if (crash := self._crash_watch.step(now_s, state)) is not self._crash:
                self._take_crash(crash)
                return
            if loss := loss_of_control(self.phase, state, flight):
                self._lose(loss, state)
                return
            flight.brake()
        _WORK[self.phase](self, state)

    # -- the operator --------------------------------------------------------------------------

    def pause(self) -> Refusal | None:
        """Holds in the air with the task frozen."""
        if self.phase is Phase.PAUSED:
            return None
        if self.phase not in UNDER_TASK:
            return Refusal(f"no pause while {self.phase.value}")
        if self._flight.progress.is_landed_by_plan:
            return ON_THE_GROUND_BY_PLAN
        self._freeze()
        self._on(SortieEvent.PAUSED)
        return None

    def resume(self) -> Refusal | None:
        """Goes on from here after a pause or a loss of control."""
        if self.phase in (Phase.TASK, Phase.RETURNING):
            return None
        if self.phase is Phase.PAUSED:
            self._on(self._goes_on)
            return None
        if self.phase is not Phase.YIELDED:
            return Refusal(f"nothing to resume while {self.phase.value}")
        if refusal := not_handed_over(self._flight.vehicle.state, self._flight.now_s):
            return refusal
        self._flight.vehicle.regain()
        self._flight.forget_setpoint()  # hold where it is, not where it was taken from us
        self._flight.report(ControlRegained())
        self._on(SortieEvent.HANDED_BACK)
        return None

    def return_home(self) -> Refusal | None:
        """Leaves the task for a flight home and lands."""
        if self.phase in (Phase.RETURNING, Phase.LANDING):
            return None
        if self.phase not in UNDER_TASK:
            return Refusal(f"no return while {self.phase.value}")
        if self._flight.progress.is_landed_by_plan:
            return ON_THE_GROUND_BY_PLAN
        if self._return_home is None:
            self._executive.stop()
            self._return_home = ReturnHome(self._flight, self._home.name)
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
        if is_ours and state is not None and state.is_armed:
            self._executive.stop()
            self._on(SortieEvent.STOPPED_IN_THE_AIR)
        else:
            self._on(SortieEvent.STOPPED)

    # -- who has control -----------------------------------------------------------------------

    def _watch_gate(self) -> None:
        """Reports when the gate begins to hold back setpoints."""
        refusal = self._flight.vehicle.refusal
        if refusal is not None and not self._was_refused:
            self._flight.report(SetpointRefused(refusal.reason))
        self._was_refused = refusal is not None

    def _take_crash(self, crash: Crash | None) -> None:
        """Lands a vehicle that has hit something and still flies; lets go of any other."""
        self._crash = crash
        self._flight.report(VehicleCrashed(str(crash)))
        if crash is not Crash.IMPACT:
            self._give_up(Aborted(str(crash)))
            return
        self.failure = Aborted(str(crash))
        if self.phase not in (Phase.HOLDING, Phase.LANDING):
            self._executive.stop()
            self._on(SortieEvent.HIT)

    def _lose(self, loss: CompanionError, state: VehicleState) -> None:
        """Yields to whoever has taken the vehicle in the air, or ends."""
        is_taken = self.phase in UNDER_TASK and self._flight.vehicle.takeover is not None
        if not (is_taken and self._may_yield and state.is_armed) or state.is_landed:
            self._give_up(loss)
            return
        self._freeze()
        self._on(SortieEvent.TAKEN_OVER, ControlYielded(str(loss)))
        self._flight.vehicle.release()

    def _freeze(self) -> None:
        """Interrupts what is flown, to go on with it later."""
        if self._return_home is None:
            self._executive.pause()
        else:
            self._return_home.stop()
        self._is_frozen = True

    @property
    def _goes_on(self) -> SortieEvent:
        """What is flown in OFFBOARD goes on."""
        is_task = self._return_home is None
        return SortieEvent.TASK_GOES_ON if is_task else SortieEvent.RETURN_GOES_ON

    # -- the work of each phase ----------------------------------------------------------------

    def _await_operator(self, state: VehicleState) -> None:
        """Nothing is sent; ends when the vehicle has landed, or is heard no longer."""
        takeover = self._flight.vehicle.takeover
        if silence := loss_of_link(state, self._flight.now_s):
            self._give_up(silence)
        elif takeover is not None and state.is_landed and not state.is_armed:
            self._give_up(Aborted(str(takeover)))

    def _begin(self, state: VehicleState) -> None:
        vehicle, home = self._flight.vehicle, self._home
        gap_m = vehicle.gap_m(home.position)
        if gap_m is None:
            return
        if elsewhere := not_at_home(gap_m, state, home):
            self._give_up(elsewhere)
            return
        vehicle.stand_at(home.position)
        if failure := self._executive.plan():
            self._give_up(failure)
            return
        self._on(SortieEvent.PLANNED)

    def _check_failsafes(self, _: VehicleState) -> None:
        """Goes on to arming when the autopilot's failsafes are known and strong, or accepted."""
        outcome = self._failsafes.tick()
        if isinstance(outcome, Failed):
            self._give_up(Aborted(outcome.reason))
        elif outcome is Progress.DONE:
            self._limit.begin()
            self._on(SortieEvent.CHECKED)

    def _pursue_goal(self, state: VehicleState) -> None:
        if self.phase is Phase.OFFBOARD:
            self._flight.hold_here()  # it may still rise
        elif self.phase in (Phase.HOLDING, Phase.PARTING, Phase.LANDING):
            self._flight.hold()  # until the autopilot does
        outcome = self._flight.vehicle.pursue(GOALS[self.phase])
        if outcome is Progress.DONE:
            is_entered = self.phase is Phase.OFFBOARD
            self._on(self._goes_on if is_entered else SortieEvent.REACHED)
        elif isinstance(outcome, Failed):
            reason = outcome.reason + last_resort(self.phase, state)
            self.failure = self.failure or Aborted(reason)
            self._flight.report(GoalFailed(reason))
            self._on(SortieEvent.FAILED)

    def _fly_task(self, _: VehicleState) -> None:
        executive = self._executive
        if limit := self._limit.due:
            self._limit.called_home_for = limit
            self._flight.report(FlightLimitReached(limit))
            self.return_home()
            return
        status = executive.resume() if self._is_frozen else executive.tick()
        self._is_frozen = False
        if status is TaskStatus.NO_PLAN:
            self._without_plan()
        elif status is TaskStatus.SATISFIED:
            self.failure = executive.failure  # set if this was only the way home
            self._on(SortieEvent.SATISFIED)
        if executive.status is TaskStatus.NEEDS_TAKE_OFF:
            self._on(SortieEvent.NEEDS_TAKE_OFF)

    def _without_plan(self) -> None:
        """Does what the mission says for the case that no plan exists."""
        executive, home = self._executive, self._home.name
        may_return = self._otherwise is Otherwise.RETURN_HOME and not executive.is_leaving
        if may_return and executive.go_to(home):
            self._flight.report(ReturnBegun(home))
            return
        self.failure = executive.failure
        is_hold = self._otherwise is Otherwise.HOLD
        self._on(SortieEvent.LEFT_ON_HOLD if is_hold else SortieEvent.OUT_OF_PLANS)

    def _fly_home(self, _: VehicleState) -> None:
        assert self._return_home is not None
        outcome = self._return_home.tick()
        if outcome is Progress.DONE:
            self._on(SortieEvent.SATISFIED)
        elif isinstance(outcome, Failed):
            failed = ReturnFailed(self._home.name, outcome.reason)
            if self._limit.called_home_for is None:
                self.failure = Aborted(failed.text)
            self._flight.report(failed)
            self._on(SortieEvent.NO_WAY_HOME)

    # -- the table -----------------------------------------------------------------------------

    def _on(self, event: SortieEvent, news: FlightEvent | None = None) -> None:
        """Enters the phase that an event leads to; reports that, or what says more."""
        self.phase = TRANSITIONS.next(self.phase, event)
        if self.phase is Phase.ENDED:
            self._flight.vehicle.release()
            is_called_home = self._return_home is not None and not self._was_stopped
            is_satisfied = self._executive.status is TaskStatus.SATISFIED
            at_limit = self._limit.ending()
            self._flight.report(ending(self.failure, is_called_home, is_satisfied, at_limit))
        else:
            self._flight.report(news or PhaseEntered(self.phase))

    def _give_up(self, failure: CompanionError) -> None:
        self.failure = failure
        self._on(SortieEvent.GIVEN_UP)


_WORK: dict[Phase, Callable[[Sortie, VehicleState], None]] = {
    Phase.WAITING: Sortie._begin,
    Phase.CHECKING: Sortie._check_failsafes,
    Phase.TASK: Sortie._fly_task,
    Phase.PAUSED: lambda sortie, _: sortie._flight.hold(),
    Phase.RETURNING: Sortie._fly_home,
    Phase.YIELDED: Sortie._await_operator,
    **dict.fromkeys(GOALS, Sortie._pursue_goal),
}
"""What each phase does in a tick; ENDED does nothing."""
