"""One sortie from the ground to the ground: climb, fly the task, land. The phases as a table.

    phase       works towards      then      if it fails
    waiting     a state on the wire          checking    (the caller's time-out)
    checking    strong failsafes             arming      end
    arming      ARMED              take-off  end
    take-off    AIRBORNE           offboard  land
    offboard    OFFBOARD           task      land
    task        the executive      landing   landing, after `otherwise`
    holding     HOLDING            landing   landing
    parting     HOLDING            end       end
    landing     LANDED             end       end

Safety comes before the table: who takes the vehicle from us (pilot or failsafe) ends the
sortie at once and nothing more is sent. A vehicle that is armed or flying before we start is
not ours to take, and one whose autopilot would not look after itself is not armed unless the
operator accepts that. A stop that the operator asked for holds, lands, and ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from companion.acting.executive import Executive, TaskStatus
from companion.acting.flight import Flight
from companion.errors import Aborted, CompanionError, LinkError, NoPlanError
from companion.geometry import horizontal_distance
from companion.mission.model import Otherwise, Place, Signal
from companion.vehicle.failsafes import REQUIREMENTS, weaknesses
from companion.vehicle.port import Goal, Outcome, Progress, VehicleState

ANSWER_TIMEOUT_S = 5.0
"""How long the autopilot may take to answer for its parameters."""
LINK_LOST_S = 10.0
"""Silence after which the sortie is given up; the autopilot's failsafe flies since long."""


class Phase(Enum):
    """Where the sortie is."""

    WAITING = "waiting for the vehicle"
    CHECKING = "checking the autopilot's failsafes"
    ARMING = "arming"
    TAKE_OFF = "taking off"
    OFFBOARD = "entering OFFBOARD"
    TASK = "flying the task"
    HOLDING = "holding"
    PARTING = "leaving the vehicle on hold"
    LANDING = "landing"
    ENDED = "ended"


@dataclass(frozen=True, slots=True)
class Step:
    """A phase that works towards a goal."""

    goal: Goal
    then: Phase
    if_failed: Phase


STEPS: dict[Phase, Step] = {
    Phase.ARMING: Step(Goal.ARMED, Phase.TAKE_OFF, Phase.ENDED),
    Phase.TAKE_OFF: Step(Goal.AIRBORNE, Phase.OFFBOARD, Phase.LANDING),
    Phase.OFFBOARD: Step(Goal.OFFBOARD, Phase.TASK, Phase.LANDING),
    Phase.HOLDING: Step(Goal.HOLDING, Phase.LANDING, Phase.LANDING),
    Phase.PARTING: Step(Goal.HOLDING, Phase.ENDED, Phase.ENDED),
    Phase.LANDING: Step(Goal.LANDED, Phase.ENDED, Phase.ENDED),
}


ON_THE_GROUND = (Phase.WAITING, Phase.CHECKING)
"""Phases in which the vehicle is not ours yet."""


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
    """

    def __init__(
        self,
        flight: Flight,
        executive: Executive,
        home: Place,
        otherwise: Otherwise,
        accepts_weak_failsafes: bool = False,
    ) -> None:
        self.phase = Phase.WAITING
        self.failure: CompanionError | None = None
        self._flight = flight
        self._executive = executive
        self._home = home
        self._otherwise = otherwise
        self._accepts_weak_failsafes = accepts_weak_failsafes
        self._checking_since_s = 0.0
        self._is_stopping = False
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
        loss = self._loss_of_control(state)
        if loss is not None:
            self._end(loss)
        elif self.phase is Phase.WAITING:
            self._start(state)
        elif self.phase is Phase.CHECKING:
            self._check_failsafes()
        elif self.phase is Phase.TASK:
            self._fly_task()
        else:
            self._work(STEPS[self.phase])

    def stop(self) -> None:
        """Holds, lands and ends from the next step on; on the ground it ends at once.

        It may be called at any time, also by a signal handler in the middle of a step.
        """
        self._is_stopping = True

    def _stop(self) -> None:
        self._is_stopping = False
        if self.phase in (Phase.HOLDING, Phase.LANDING):
            return
        self._flight.report("phase", "stopping as asked")
        state = self._flight.vehicle.state
        if self.phase in ON_THE_GROUND or state is None or not state.is_armed:
            self._enter(Phase.ENDED)
        else:
            self._executive.stop()
            self._enter(Phase.HOLDING)

    def _watch_gate(self) -> None:
        """Reports when the gate begins to hold back setpoints."""
        refusal = self._flight.vehicle.refusal
        if refusal and not self._was_refused:
            self._flight.report("gate", f"setpoint refused, holding: {refusal}", reason=refusal)
        self._was_refused = bool(refusal)

    def _loss_of_control(self, state: VehicleState) -> CompanionError | None:
        """Why the sortie is no longer ours to fly, or never was."""
        silence_s = self._flight.now_s - state.stamp_s
        if silence_s > LINK_LOST_S:
            return LinkError(f"no position from the vehicle for {silence_s:.0f} s")
        if self._flight.vehicle.lost_authority:
            return Aborted(self._flight.vehicle.lost_authority)
        if self.phase in ON_THE_GROUND and (state.is_armed or not state.is_landed):
            return Aborted("the vehicle is armed or flying already; it is left alone")
        is_flying = self.phase in (Phase.OFFBOARD, Phase.TASK, Phase.HOLDING)
        if is_flying and not state.is_armed and not self._flight.is_grounded:
            return Aborted("the vehicle was disarmed")
        return None

    def _start(self, state: VehicleState) -> None:
        gap_m = horizontal_distance(state.position, self._home.position)
        if gap_m > self._home.radius_m:
            what = f"the vehicle stands {gap_m:.1f} m from {self._home.name}"
            self._end(Aborted(f"{what}, where the mission begins; put it there"))
            return
        try:
            self._executive.plan()
        except NoPlanError as error:
            self._end(error)
            return
        self._checking_since_s = self._flight.now_s
        self._enter(Phase.CHECKING)

    def _check_failsafes(self) -> None:
        """Goes on to arming when the autopilot's failsafes are known and strong, or accepted."""
        vehicle = self._flight.vehicle
        values = {r.parameter: vehicle.parameter(r.parameter) for r in REQUIREMENTS}
        is_late = self._flight.now_s - self._checking_since_s > ANSWER_TIMEOUT_S
        if None in values.values() and not is_late:
            return
        weak = weaknesses(values)
        if weak and not self._accepts_weak_failsafes:
            lines = "\n    ".join(weak)
            self._end(
                Aborted(f"the autopilot's failsafes are weak, so it is not armed\n    {lines}")
            )
            return
        for line in weak:
            self._flight.report("phase", f"accepted: {line}")
        self._enter(Phase.ARMING)

    def _work(self, step: Step) -> None:
        outcome: Outcome = self._flight.vehicle.pursue(step.goal)
        if self.phase is Phase.OFFBOARD:
            self._flight.hold()
        if outcome.progress is Progress.DONE:
            self._enter(step.then)
        elif outcome.progress is Progress.FAILED:
            if self.failure is None:
                self.failure = Aborted(outcome.reason)
            self._flight.report("phase", outcome.reason)
            self._enter(step.if_failed)

    def _fly_task(self) -> None:
        executive = self._executive
        status = executive.tick()
        if status is TaskStatus.NO_PLAN:
            self._without_plan()
        elif status is TaskStatus.SATISFIED:
            self.failure = executive.failure  # set if this was only the way home
            self._enter(Phase.LANDING)
        if executive.needs_take_off:
            executive.needs_take_off = False
            self._enter(Phase.ARMING)

    def _without_plan(self) -> None:
        """Does what the mission says for the case that no plan exists."""
        executive, home = self._executive, self._home.name
        may_return = self._otherwise is Otherwise.RETURN_HOME and not executive.is_leaving
        if may_return and executive.go_to(home):
            self._flight.report("phase", f"returning to {home}")
        else:
            self.failure = executive.failure
            is_hold = self._otherwise is Otherwise.HOLD
            self._enter(Phase.PARTING if is_hold else Phase.HOLDING)

    def _enter(self, phase: Phase) -> None:
        self.phase = phase
        if phase is Phase.ENDED:
            self._flight.vehicle.release()
            text, code = self._ending()
            self._flight.report("end", text, exit_code=code)
        else:
            self._flight.report("phase", phase.value)

    def _ending(self) -> tuple[str, int]:
        """How the sortie has ended, in words and as an exit code."""
        if self.failure is not None:
            return str(self.failure), self.failure.exit_code
        is_satisfied = self._executive.status is TaskStatus.SATISFIED
        return ("task satisfied, landed" if is_satisfied else "stopped as asked"), 0

    def _end(self, failure: CompanionError) -> None:
        self.failure = failure
        self._enter(Phase.ENDED)
