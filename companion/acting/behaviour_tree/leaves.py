"""The leaves of the tree (Figs. 5 and 6): conditions, effects, symbols, commands and rest.

`initialise` runs when a leaf is entered, `update` once per tick, `terminate` when it is left;
with status INVALID if something above has interrupted it. Time comes from the flight, never
from a clock. The leaf that flies is in move.py, those that land in landing.py.
"""

from __future__ import annotations

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from companion.acting.behaviour_tree.intention import Intention
from companion.acting.behaviour_tree.leaf import Leaf, failure_of
from companion.acting.behaviour_tree.move import MoveCommand
from companion.acting.behaviour_tree.payload_command import PayloadCommand
from companion.acting.flight import Flight
from companion.acting.place_functions import PlaceFunctions
from companion.acting.replanning.assumptions import Assumptions
from companion.flight_events.facts import BeliefWithdrawn
from companion.flight_events.skills import PlaceReached, SkillCompleted, SkillFailed
from companion.flight_events.tree import LeafType
from companion.mission.steps import Command
from companion.planning.domain import is_one_flight
from companion.slices import InSlices

RUNNING = Status.RUNNING


class AssumptionsHold(Leaf):
    """Leftmost branch: the events that matter to the plan still have their assumed values."""

    does = LeafType.ASSUMPTIONS

    def __init__(self, flight: Flight, assumptions: Assumptions) -> None:
        super().__init__(flight, "as predicted?")
        self._assumptions = assumptions

    def update(self) -> Status:
        """FAILURE at the first difference, which causes a replan."""
        if self._flight.progress.is_landed_by_plan:
            return Status.SUCCESS  # what was begun on the ground is finished first
        wrong = self._assumptions.wrong
        return self.fail(", ".join(wrong)) if wrong else Status.SUCCESS


class Precondition(Leaf):
    """Green block: the precondition holds, so the present position is left.

    Before that, nothing of the action has begun. So this is the moment for a better plan, if one
    may exist, and for waiting until it is known whether a dropped line of the task can be kept
    again. After a skill on the ground it waits until the events have been examined. A retry
    continues a failed flight from where that ended.

    Args:
        assumptions: those of the plan; None if it has none.
    """

    does = LeafType.PRECONDITION

    def __init__(
        self, flight: Flight, intention: Intention, assumptions: Assumptions | None
    ) -> None:
        super().__init__(flight, f"pre {intention.name}")
        self._intention = intention
        self._assumptions = assumptions

    def update(self) -> Status:
        """FAILURE if a fact is missing, or a better plan may exist."""
        task, intention = self._flight.task, self._intention
        assumptions, is_landed = self._assumptions, self._flight.progress.is_landed_by_plan
        if assumptions is not None and assumptions.may_do_better:
            return self.fail("")
        is_surprised = assumptions is not None and bool(assumptions.wrong)
        if (task.lines.may_take_up or is_surprised) and not is_landed:
            self._flight.guidance.hold()
            return Status.RUNNING
        if intention.tries.is_any and (again := task.interrupted(intention.actions)) is not None:
            task.resume_flight(again)
            intention.action = again
            return Status.SUCCESS
        facts = task.all_facts
        intention.choose(facts)
        if not intention.action.is_applicable(facts):
            missing = sorted(intention.action.requires - facts)
            wanting = ", ".join(missing) or "a forbidden fact"
            return self.fail(f"{intention.name} cannot begin: {wanting}")
        task.begin(intention.action)
        return Status.SUCCESS


class StillThere(Leaf):
    """In a tree written by hand: ends an action at a place when the vehicle is elsewhere.

    A plan that loses its place is replaced. A tree by hand is not replaced, so the action fails.
    """

    does = LeafType.STILL_THERE

    def __init__(self, flight: Flight, intention: Intention) -> None:
        super().__init__(flight, "still there?")
        self._intention = intention

    def update(self) -> Status:
        """FAILURE once the action is no longer under way for the task."""
        if self._flight.task.running is self._intention.action:
            return Status.SUCCESS
        return self.fail(f"{self._intention.name} was interrupted: its place is lost")


class Effects(Leaf):
    """Blue block: applies the effects to the task's state.

    Args:
        ends_lap: whether the action is the last one of the loop.
    """

    does = LeafType.EFFECTS

    def __init__(self, flight: Flight, intention: Intention, ends_lap: bool) -> None:
        super().__init__(flight, f"eff {intention.name}")
        self._intention = intention
        self._ends_lap = ends_lap

    def update(self) -> Status:
        """Always SUCCESS."""
        flight, action = self._flight, self._intention.action
        flight.task.complete(action, flight.now_s)
        if action.destination is not None and is_one_flight(action.execute):
            flight.report(PlaceReached(action.destination, action.name))
        elif action.assumes or action.adds:
            flight.report(SkillCompleted(action.name))
        flight.progress.completed += 1
        flight.progress.laps += self._ends_lap
        return Status.SUCCESS


class Withdraw(Leaf):
    """Right branch of Fig. 6: the skill has failed, so its assumptions are withdrawn.

    Nothing is withdrawn if the skill did not begin because its precondition does not hold, or if a
    tree written by hand tries it again.

    Args:
        left: the left branch of the figure.
    """

    does = LeafType.WITHDRAW

    def __init__(self, flight: Flight, intention: Intention, left: Behaviour) -> None:
        assumed = ", ".join(sorted(intention.action.assumes)) or "nothing"
        is_one = len(intention.actions) == 1
        what = assumed if is_one else f"what {intention.name} assumes"
        super().__init__(flight, f"withdraw {what}")
        self._intention = intention
        self._left = left

    def update(self) -> Status:
        """Always SUCCESS; the inverter above turns it into the FAILURE that causes a replan."""
        flight, action = self._flight, self._intention.action
        self.feedback_message = failure_of(self._left)
        if flight.task.running is not action:
            return Status.SUCCESS
        failed = SkillFailed(action.name, self.feedback_message)
        self.feedback_message = failed.text
        flight.report(failed)
        if self._intention.tries.next is not None:
            return Status.SUCCESS
        flight.steps.end_skill(action)
        flight.progress.failed = action
        after_s = flight.belief_retry_s if action.retry_after_s is None else action.retry_after_s
        retry_s = None if after_s is None else flight.now_s + after_s
        flight.task.withdraw(action.assumes, retry_s)
        for belief in sorted(action.assumes):
            flight.report(BeliefWithdrawn(belief))
        return Status.SUCCESS


class UpdateParam(Leaf):
    """update_param(c, w): chooses for the symbol `w` a waypoint that can be flown to now.

    `c` is always the vehicle's present state, so nothing has to be chosen for it. If the flight of
    the last try has failed, it chooses another waypoint.

    Args:
        move: flies to the waypoint; the reason why it failed last is more helpful than the message
            that no other waypoint is left.
    """

    does = LeafType.UPDATE_PARAM

    def __init__(self, flight: Flight, place: str, move: MoveCommand) -> None:
        super().__init__(flight, f"update_param {place}")
        self._place = place
        self._move = move
        self._grounding: InSlices[bool] | None = None

    def initialise(self) -> None:
        """Begins with the previous waypoint, unless a flight to it has failed."""
        flight, place, state = self._flight, self._place, self._flight.vehicle.state
        self._before = flight.symbols[place]
        self._has_failed = self._move.failed_at == flight.task.word.positions
        if self._has_failed:
            flight.symbols.refuse(place, flight.now_s)
        if state is not None:
            ground, advice = flight.symbols.ground, PlaceFunctions(flight)
            here = state.motion.position
            self._grounding = InSlices(lambda: ground(place, here, flight.now_s, advice))

    def update(self) -> Status:
        """FAILURE if no waypoint of the place can be flown to on the present map.

        The search for routes may take some ticks; the vehicle holds meanwhile.
        """
        flight, place, grounding = self._flight, self._place, self._grounding
        if grounding is not None and not grounding.step():
            flight.guidance.hold()
            return Status.RUNNING
        if grounding is None or not grounding.result:
            last_failure = self._move.feedback_message if self._has_failed else ""
            return self.fail(last_failure or f"no waypoint of {place} can be flown to")
        if flight.symbols[place] is not self._before:
            flight.tell_symbol(place)
        return Status.SUCCESS

    def terminate(self, new_status: Status) -> None:
        """Drops a waypoint that was only being tried."""
        if self._grounding is not None:
            self._grounding.abandon()
            self._grounding = None


class SendCommand(Leaf):
    """Sends a MAVLink command to a component and holds until its final answer.

    The journal has the intention on the disk before the command is sent.
    """

    does = LeafType.COMMAND

    def __init__(self, flight: Flight, command: Command, timeout_s: float | None) -> None:
        super().__init__(flight, f"command {command.name}")
        self._command = command
        self._timeout_s = timeout_s
        self._sent: PayloadCommand | None = None

    def initialise(self) -> None:
        """Writes down the intention, or returns to an earlier one."""
        self._sent = PayloadCommand(self._flight, self.owner(), self._command, self._timeout_s)

    def update(self) -> Status:
        """SUCCESS if it was accepted."""
        assert self._sent is not None
        self._flight.guidance.hold()
        return self.status_of(self._sent.progress())

    def terminate(self, new_status: Status) -> None:
        """Stops waiting for it."""
        if new_status is not RUNNING and self._sent is not None:
            self._sent.leave()
            self._sent = None


class Sleep(Leaf):
    """Succeeds after a time; does not tell the vehicle what to do meanwhile."""

    does = LeafType.WAIT

    def __init__(self, flight: Flight, name: str, duration_s: float) -> None:
        super().__init__(flight, name)
        self._duration_s = duration_s

    def initialise(self) -> None:
        """Starts the timer."""
        self._end_s = self._flight.now_s + self._duration_s

    def update(self) -> Status:
        """SUCCESS when the time is over."""
        return Status.SUCCESS if self._flight.now_s >= self._end_s else Status.RUNNING


class Rest(Sleep):
    """Holds position for a time."""

    def update(self) -> Status:
        """SUCCESS when the time is over."""
        self._flight.guidance.hold()
        return super().update()
