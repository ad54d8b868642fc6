"""The leaves of the tree (Figs. 5 and 6): conditions, effects, symbols, commands and rest.

`initialise` runs when a leaf is entered, `update` once per tick, `terminate` when it is left;
with status INVALID if something above has interrupted it. Time comes from the flight, never
from a clock. The leaf that flies is in moving.py, those that land in ground.py.
"""

from __future__ import annotations

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from companion.acting.flight import Flight
from companion.acting.replanning.assumptions import Assumptions
from companion.mission.model import Command
from companion.planning.domain import Action
from companion.vehicle.port import Progress


class AssumptionsHold(Behaviour):
    """Leftmost branch: do the events that matter to the plan still have their values?"""

    def __init__(self, flight: Flight, assumptions: Assumptions) -> None:
        super().__init__("as predicted?")
        self._flight = flight
        self._predictions = assumptions

    def update(self) -> Status:
        """FAILURE on the first difference, which replans."""
        if self._flight.is_grounded:
            return Status.SUCCESS  # what was begun on the ground is finished first
        wrong = self._predictions.wrong
        self.feedback_message = ", ".join(wrong)
        return Status.FAILURE if wrong else Status.SUCCESS


class Precondition(Behaviour):
    """Green block: does the precondition hold? If so the present position is left.

    Before it, nothing of the action has begun: the moment for a better plan, if there may be one.
    """

    def __init__(self, flight: Flight, action: Action) -> None:
        super().__init__(f"pre {action.name}")
        self._flight = flight
        self._action = action

    def update(self) -> Status:
        """FAILURE if a fact is missing."""
        task = self._flight.task
        if self._flight.may_do_better:
            return Status.FAILURE
        if not self._action.is_applicable(task.all_facts):
            missing = sorted(self._action.requires - task.all_facts)
            wanting = ", ".join(missing) or "a forbidden fact"
            self._flight.failure = f"{self._action.name} cannot begin: {wanting}"
            return Status.FAILURE
        task.begin(self._action)
        return Status.SUCCESS


class Effects(Behaviour):
    """Blue block: takes the effects over into the task's state.

    Args:
        ends_lap: whether the action is the last one of the loop.
    """

    def __init__(self, flight: Flight, action: Action, ends_lap: bool) -> None:
        super().__init__(f"eff {action.name}")
        self._flight = flight
        self._action = action
        self._ends_lap = ends_lap

    def update(self) -> Status:
        """Always SUCCESS."""
        flight, action = self._flight, self._action
        flight.task.complete(action)
        if action.destination is not None and len(action.execute) == 1:
            flight.report("at", f"at {action.destination}", action=action.name)
        elif action.assumes or action.adds:
            flight.report("done", f"{action.name} done", action=action.name)
        flight.failure = ""
        flight.completed += 1
        flight.laps += self._ends_lap
        return Status.SUCCESS


class Withdraw(Behaviour):
    """Right branch of Fig. 6: the skill has failed, so what it assumed is not believed.

    A skill that has not begun, because its precondition does not hold, disproves nothing.
    """

    def __init__(self, flight: Flight, action: Action) -> None:
        super().__init__(f"withdraw {', '.join(sorted(action.assumes)) or 'nothing'}")
        self._flight = flight
        self._action = action

    def update(self) -> Status:
        """Always SUCCESS; the inverter above turns it into the FAILURE that replans."""
        flight, action = self._flight, self._action
        if flight.task.running is not action:
            return Status.SUCCESS
        flight.failure = f"{action.name} failed: {flight.failure}"
        flight.report("failed", flight.failure, action=action.name)
        after_s = flight.belief_retry_s if action.retry_after_s is None else action.retry_after_s
        retry_s = None if after_s is None else flight.now_s + after_s
        flight.task.withdraw(action.assumes, retry_s)
        for belief in sorted(action.assumes):
            flight.report("withdrawn", f"belief {belief} withdrawn", belief=belief)
        return Status.SUCCESS


class UpdateParam(Behaviour):
    """update_param(c, w): grounds the symbol `w` to a waypoint that can be flown to now.

    `c` is always the vehicle's present state, so there is nothing to ground for it. Asked again for
    the same action, it takes another waypoint: a flight to the last one has failed.
    """

    def __init__(self, flight: Flight, place: str) -> None:
        super().__init__(f"update_param {place}")
        self._flight = flight
        self._place = place
        self._tried_at: int | None = None

    def update(self) -> Status:
        """FAILURE if no waypoint of the place can be flown to on the map as it is known now."""
        flight, place, state = self._flight, self._place, self._flight.vehicle.state
        before = flight.symbols[place]
        is_another_try = self._tried_at == flight.task.positions
        self._tried_at = flight.task.positions
        if is_another_try:
            flight.symbols.refuse(place, flight.now_s)
        if state is None or not flight.symbols.ground(place, state.position, flight.now_s):
            if not is_another_try:  # else the failure of the last try says more
                flight.failure = f"no waypoint of {place} can be flown to"
            return Status.FAILURE
        if flight.symbols[place] is not before:
            flight.tell_symbol(place)
        return Status.SUCCESS


class SendCommand(Behaviour):
    """Sends a MAVLink command to a component and waits, holding, for its final answer."""

    def __init__(self, flight: Flight, command: Command, timeout_s: float | None) -> None:
        super().__init__(f"command {command.name}")
        self._flight = flight
        self._command = command
        self._timeout_s = timeout_s
        self._ticket: int | None = None

    def initialise(self) -> None:
        """Sends it for the first time."""
        flight, command = self._flight, self._command
        self._start_s = flight.now_s
        self._ticket = flight.vehicle.send_command(
            command.component, command.command, command.parameters
        )

    def update(self) -> Status:
        """SUCCESS if it was accepted."""
        flight = self._flight
        flight.hold()
        assert self._ticket is not None
        outcome = flight.vehicle.command_outcome(self._ticket)
        if outcome.progress is Progress.DONE:
            return Status.SUCCESS
        if outcome.progress is Progress.FAILED:
            flight.failure = outcome.reason
            return Status.FAILURE
        if self._timeout_s is not None and flight.now_s - self._start_s > self._timeout_s:
            flight.failure = f"no final answer in {self._timeout_s:.0f} s"
            return Status.FAILURE
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Stops asking."""
        if self._ticket is not None and new_status is not Status.RUNNING:
            self._flight.vehicle.forget_command(self._ticket)
            self._ticket = None


class Rest(Behaviour):
    """Holds position for a time."""

    def __init__(self, flight: Flight, duration_s: float) -> None:
        super().__init__("rest")
        self._flight = flight
        self._duration_s = duration_s

    def initialise(self) -> None:
        """Starts the time."""
        self._end_s = self._flight.now_s + self._duration_s

    def update(self) -> Status:
        """SUCCESS when the time is over."""
        self._flight.hold()
        return Status.SUCCESS if self._flight.now_s >= self._end_s else Status.RUNNING
