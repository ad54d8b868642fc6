"""One sortie from the ground to the ground: climb, fly the task, land; phases.py has the table.

Safety comes before the table: who takes the vehicle from us (pilot or failsafe) ends the sortie at
once and nothing more is sent; or, where an operator may give control back, the sortie yields and
waits for that. A vehicle that is armed or flying before we start is not ours to take, and one whose
autopilot would not look after itself is not armed unless the operator accepts that. A stop that the
operator asked for holds, lands, and ends.

The operator may also pause (hold in the air, the task frozen), let it go on, and call it home.
Whose the vehicle is, and when it is handed over again, is asked in authority.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

from py_trees.common import Status

from companion.acting.authority import loss_of_control, loss_of_link, not_handed_over
from companion.acting.executive import Executive, TaskStatus
from companion.acting.flight import Flight
from companion.acting.phases import ON_THE_GROUND, STEPS, UNDER_TASK, Phase, Step
from companion.acting.return_home import ReturnHome
from companion.errors import Aborted, CompanionError, NoPlanError
from companion.geometry import horizontal_distance
from companion.mission.model import Otherwise, Place, Signal
from companion.vehicle.failsafes import REQUIREMENTS, weaknesses
from companion.vehicle.port import Outcome, Progress, VehicleState

ANSWER_TIMEOUT_S = 5.0
"""How long the autopilot may take to answer for its parameters."""
GROUNDED = "the vehicle is landing or on the ground by its plan; nothing interrupts that"


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
    """

    def __init__(
        self,
        flight: Flight,
        executive: Executive,
        home: Place,
        otherwise: Otherwise,
        accepts_weak_failsafes: bool = False,
        may_yield: bool = False,
    ) -> None:
        self.phase = Phase.WAITING
        self.failure: CompanionError | None = None
        self._flight = flight
        self._executive = executive
        self._home = home
        self._otherwise = otherwise
        self._accepts_weak_failsafes = accepts_weak_failsafes
        self._may_yield = may_yield
        self._homing: ReturnHome | None = None
        self._is_frozen = False
        self._asked_s: float | None = None
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
        if self.phase is Phase.YIELDED:
            self._await_operator(state)
            return
        loss = loss_of_control(self.phase, state, self._flight)
        if loss is not None:
            self._lose(loss, state)
        elif self.phase is Phase.WAITING:
            self._start(state)
        elif self.phase is Phase.CHECKING:
            self._check_failsafes()
        elif self.phase is Phase.TASK:
            self._fly_task()
        elif self.phase is Phase.RETURNING:
            self._fly_home()
        elif self.phase is Phase.PAUSED:
            self._flight.hold()
        else:
            self._work(STEPS[self.phase])

    def rehearse(self) -> None:
        """Makes the first plan once before anything is timed; the one at the start is quick then.

        A plan that does not exist is told at the start.
        """
        with suppress(NoPlanError):
            self._executive.rehearse()

    # -- the operator --------------------------------------------------------------------------

    def pause(self) -> str:
        """Holds in the air with the task frozen; returns why it does not, or ""."""
        if self.phase is Phase.PAUSED:
            return ""
        if self.phase not in UNDER_TASK:
            return f"no pause while {self.phase.value}"
        if self._flight.is_grounded:
            return GROUNDED
        self._freeze(Phase.PAUSED)
        return ""

    def go_on(self) -> str:
        """Goes on from here after a pause or a loss of control; returns why it does not, or ""."""
        if self.phase in (Phase.TASK, Phase.RETURNING):
            return ""
        if self.phase is Phase.PAUSED:
            self._enter(self._flown)
            return ""
        if self.phase is not Phase.YIELDED:
            return f"nothing to go on with while {self.phase.value}"
        if reason := not_handed_over(self._flight.vehicle.state, self._flight.now_s):
            return reason
        self._flight.vehicle.regain()
        self._flight.setpoint = None  # hold where the vehicle is, not where it was taken from us
        self._flight.report("phase", "control given back by the operator")
        self._enter(Phase.OFFBOARD)
        return ""

    def go_home(self) -> str:
        """Leaves the task for a flight home and lands; returns why it does not, or ""."""
        if self.phase in (Phase.RETURNING, Phase.LANDING):
            return ""
        if self.phase not in UNDER_TASK:
            return f"no return while {self.phase.value}"
        if self._flight.is_grounded:
            return GROUNDED
        if self._homing is None:
            self._executive.stop()
            self._homing = ReturnHome(self._flight, self._home.name)
        self._enter(Phase.RETURNING)
        return ""

    def stop(self) -> None:
        """Holds, lands and ends from the next step on; on the ground it ends at once.

        It may be called at any time, also by a signal handler in the middle of a step.
        """
        self._is_stopping = True

    def _stop(self) -> None:
        self._is_stopping, self._was_stopped = False, True
        if self.phase in (Phase.HOLDING, Phase.LANDING):
            return
        self._flight.report("phase", "stopping as asked")
        state = self._flight.vehicle.state
        is_ours = self.phase not in (*ON_THE_GROUND, Phase.YIELDED)
        if not is_ours or state is None or not state.is_armed:
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

    def _lose(self, loss: CompanionError, state: VehicleState) -> None:
        """Yields to whoever has taken the vehicle in the air, or ends."""
        has_yielded = self.phase in UNDER_TASK and bool(self._flight.vehicle.lost_authority)
        if not (has_yielded and self._may_yield and state.is_armed) or state.is_landed:
            self._end(loss)
            return
        self._freeze(Phase.YIELDED, f"{loss}; hold, then continue, gives it back")
        self._flight.vehicle.release()

    def _await_operator(self, state: VehicleState) -> None:
        """Nothing is sent; ends when the vehicle has landed, or is heard no longer."""
        if silence := loss_of_link(state, self._flight.now_s):
            self._end(silence)
        elif state.is_landed and not state.is_armed:
            self._end(Aborted(self._flight.vehicle.lost_authority))

    def _freeze(self, phase: Phase, text: str = "") -> None:
        """Interrupts what is flown, to go on with it later."""
        if self._homing is None:
            self._executive.stop()
        else:
            self._homing.stop()
        self._is_frozen = True
        self._enter(phase, text)

    @property
    def _flown(self) -> Phase:
        """What is flown in OFFBOARD."""
        return Phase.TASK if self._homing is None else Phase.RETURNING

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
        self._enter(Phase.CHECKING)

    def _check_failsafes(self) -> None:
        """Goes on to arming when the autopilot's failsafes are known and strong, or accepted.

        The time for an answer begins with the question: the tick before has planned, which may
        have taken longer than an answer may.
        """
        vehicle, now_s = self._flight.vehicle, self._flight.now_s
        if self._asked_s is None:
            self._asked_s = now_s
        values = {r.parameter: vehicle.parameter(r.parameter) for r in REQUIREMENTS}
        is_late = now_s - self._asked_s > ANSWER_TIMEOUT_S
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
            self._enter(self._flown if step.then is Phase.TASK else step.then)
        elif outcome.progress is Progress.FAILED:
            if self.failure is None:
                self.failure = Aborted(outcome.reason)
            self._flight.report("phase", outcome.reason)
            self._enter(step.if_failed)

    def _fly_task(self) -> None:
        executive = self._executive
        status = executive.resume() if self._is_frozen else executive.tick()
        self._is_frozen = False
        if status is TaskStatus.NO_PLAN:
            self._without_plan()
        elif status is TaskStatus.SATISFIED:
            self.failure = executive.failure  # set if this was only the way home
            self._enter(Phase.LANDING)
        if executive.needs_take_off:
            executive.needs_take_off = False
            self._enter(Phase.ARMING)

    def _fly_home(self) -> None:
        assert self._homing is not None
        status = self._homing.tick()
        if status is Status.SUCCESS:
            self._enter(Phase.LANDING)
        elif status is Status.FAILURE:
            self.failure = Aborted(f"cannot return to {self._home.name}: {self._flight.failure}")
            self._flight.report("phase", str(self.failure))
            self._enter(Phase.HOLDING)

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

    def _enter(self, phase: Phase, text: str = "") -> None:
        self.phase = phase
        if phase is Phase.ENDED:
            self._flight.vehicle.release()
            text, code = self._ending()
            self._flight.report("end", text, exit_code=code)
        else:
            self._flight.report("phase", text or phase.value)

    def _ending(self) -> tuple[str, int]:
        """How the sortie has ended, in words and as an exit code."""
        if self.failure is not None:
            return str(self.failure), self.failure.exit_code
        if self._homing is not None and not self._was_stopped:
            return "returned as asked, landed", 0
        is_satisfied = self._executive.status is TaskStatus.SATISFIED
        return ("task satisfied, landed" if is_satisfied else "stopped as asked"), 0

    def _end(self, failure: CompanionError) -> None:
        self.failure = failure
        self._enter(Phase.ENDED)
