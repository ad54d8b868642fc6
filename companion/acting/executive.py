"""Ticks the plan's tree, notices what the plan did not expect, and plans again (Section III-B).

Planning assumes that every event keeps its value and every belief holds. When the tree fails,
one of these was wrong: an event that matters to the plan has changed, or a skill has failed
and its belief was withdrawn. Then a new lasso is searched from the present state, with the
history kept, and a new tree is built. The vehicle holds meanwhile.

Plans change as little as possible. An event that matters, but leaves the rest of the plan the best
one, changes nothing. A belief that comes back makes a new plan at the next completed skill.

A plan that ends at rest satisfies the task when the rest is reached.

Each position of the word is reported when it is left, and so is each conjunct that it violates.
A violated task is not flown to its end as if it could be satisfied: a plan is searched again, which
says that there is none. On the way home after a violation no event is watched but one by which all
violated lines begin anew: no other could give the task a plan again.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from enum import Enum

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from companion.acting.behaviour_tree.builder import build
from companion.acting.behaviour_tree.hand_built import build_by_hand
from companion.acting.behaviour_tree.tree_report import TreeReport
from companion.acting.event_detector import EventDetector, in_words
from companion.acting.flight import Flight
from companion.acting.positions import tell_positions
from companion.acting.replanning.assumptions import Assumptions
from companion.acting.replanning.explanation import ExplanationSearch
from companion.acting.replanning.reachability import Reachability
from companion.errors import NoPlanError
from companion.mission.model import Fly, Signal
from companion.planning.domain import WAIT, Action, Fact, departures
from companion.planning.lasso import Lasso
from companion.planning.planner import Planner

COMPARED = 1000
"""Actions of two plans after which they are taken for the same."""
MAX_IDLE_REPLANS = 5
"""Replans without a completed skill between them after which the executive gives up."""

PATIENCE_S = 5.0
"""How long a replan waits for a map that goes on changing while the vehicle holds."""


class TaskStatus(Enum):
    """How the task stands."""

    RUNNING = "running"
    SATISFIED = "satisfied"
    NO_PLAN = "no plan"


class Executive:
    """Acts out one mission.

    Attributes:
        status: how the task stands.
        replans: how often it has planned again.
        lasso: the present plan.
        failure: why the task has no plan; None while it has one.
        is_leaving: the present plan is a flight to a place, in want of one for the task.
        needs_take_off: a new plan was made while the vehicle was on the ground by the old one.

    Args:
        planner: the mission's planner.
        flight: what the tree acts on.
        detector: the mission's events.
    """

    def __init__(self, planner: Planner, flight: Flight, detector: EventDetector) -> None:
        self.status = TaskStatus.RUNNING
        self.replans = 0
        self.lasso: Lasso | None = None
        self.failure: NoPlanError | None = None
        self.is_leaving = self.needs_take_off = False
        self._planner = planner
        self._flight = flight
        self._detector = detector
        self._root: Behaviour | None = None
        self._tree_report: TreeReport | None = None
        self._predictions = Assumptions(planner, flight)
        self._idle_replans = 0
        self._positions = 0
        self._due, self._due_s = "", 0.0
        self._inquiry: ExplanationSearch | None = None
        self._reachability = Reachability(planner, flight)

    def sense(self, readings: Sequence[tuple[Signal, float]]) -> None:
        """Takes readings off the wire and turns them into facts."""
        flight, events = self._flight, self._planner.mission.events
        restores: frozenset[str] = frozenset()
        for name, holds in self._detector.update(flight.now_s, readings):
            flight.task.take(events[name], holds)
            flight.report("event", in_words(name, holds), event=name, holds=holds)
            restores |= events[name].restores if holds else frozenset()
        for belief in flight.task.restore(flight.now_s, restores):
            flight.report("restored", f"belief {belief} restored", belief=belief)
            flight.may_do_better = True

    def rehearse(self) -> None:
        """Searches the first plan and forgets it; what the search has learned is kept.

        Raises:
            NoPlanError: there is none.
        """
        if self._planner.mission.tree is None:
            self._planner.solve(*self._flight.task.problem())

    def plan(self) -> None:
        """Makes the first plan.

        Raises:
            NoPlanError: there is none.
        """
        task = {name: str(formula) for name, formula in self._planner.mission.task.items()}
        if (tree := self._planner.mission.tree) is not None:
            self._root = build_by_hand(self._flight, tree, self._planner.actions_of(tree))
            self._flight.report("plan", "the mission's own tree", number=0, task=task)
            self._tree_report = TreeReport(self._flight, self._root)
            self._tell_tree()
            return
        self._reachability.follow()
        lasso = self._planner.solve(*self._flight.task.problem()).lasso
        self._adopt(lasso)
        self._flight.report("plan", f"plan: {lasso}", number=0, task=task, **lasso.as_json())
        self._tell_tree()

    def tick(self) -> TaskStatus:
        """One tick of the tree; plans again if it fails."""
        assert self._root is not None
        if self.lasso is None:
            return self._tick_by_hand(self._root)
        if self._due:
            return self._plan_again()
        flight, laps = self._flight, self._flight.laps
        assumptions = self._predictions
        assumptions.narrow(self.lasso)
        if assumptions.wrong and not flight.is_grounded and self._is_still_best(self.lasso):
            assumptions.renew()
        if (
            not flight.is_grounded
            and self._reachability.have_changed()
            and self._reachability.are_known()
        ):
            lost = self._reachability.follow()
            if lost and not self.is_leaving and not self._is_still_best(self.lasso):
                self._replan(lost)
                return self.status
        if flight.may_do_better and self.is_leaving:
            if not flight.task.violated and self._plan_now() is not None:
                self._replan()
                return self.status
            flight.may_do_better = False
        self._root.tick_once()
        self._tell_tree()
        tell_positions(self._flight)
        is_done = flight.laps > laps and self.lasso.ends_at_rest
        if self._root.status is Status.FAILURE or self._is_in_vain(is_done):
            self._replan()
        elif is_done:
            self.status = TaskStatus.SATISFIED
            self._rest()
        elif flight.laps > laps:
            flight.report("lap", f"lap {flight.laps} done", lap=flight.laps)
        return self.status

    def _tick_by_hand(self, root: Behaviour) -> TaskStatus:
        """One tick of a tree that was written by hand: it is not replaced when it fails."""
        root.tick_once()
        self._tell_tree()
        tell_positions(self._flight)
        if root.status is Status.SUCCESS:
            self.status = TaskStatus.SATISFIED
            self._rest()
        elif root.status is Status.FAILURE:
            self._flight.task.interrupt()
            self.status = TaskStatus.NO_PLAN
            self.failure = NoPlanError(f"the tree has failed: {self._flight.failure}")
            self._flight.report("failed", str(self.failure))
        return self.status

    def go_to(self, place: str) -> bool:
        """Replaces the plan by a flight to a place and rest; False if no route leads there.

        This is what is left to do when the task has no plan, whatever the skill that flies there
        would ask for otherwise.
        """
        self._flight.task.interrupt()
        move = self._departure(place)
        if move is None:
            return False
        self._flight.task.depart()
        tell_positions(self._flight)
        self.status = TaskStatus.RUNNING
        self.is_leaving = True
        self._adopt(Lasso((move,), (WAIT,)))
        self._tell_tree()
        return True

    def stop(self) -> None:
        """Ends the plan; the vehicle holds."""
        if self._root is not None:
            self._root.stop(Status.INVALID)
            self._tell_tree()
        self._flight.hold()

    def resume(self) -> TaskStatus:
        """Goes on after `stop`, by a new plan from here: what was under way was interrupted."""
        if self._planner.mission.tree is None:
            self.is_leaving = False
            self._idle_replans = 0
            self._replan("going on")
        return self.status

    def _departure(self, place: str) -> Action | None:
        moves = departures(self._planner.mission, self._planner.flight_time)
        move = next((a for a in moves if a.execute == (Fly(place),)), None)
        nothing: frozenset[Fact] = frozenset()
        return move and replace(move, requires=nothing, forbids=nothing, assumes=nothing)

    def _is_in_vain(self, is_done: bool) -> bool:
        """Whether the plan is for a task that is violated; on the ground it ends first."""
        may_end = is_done or not self._flight.is_grounded
        return bool(self._flight.task.violated) and may_end and not self.is_leaving

    def _replan(self, why: str = "") -> None:
        flight, task = self._flight, self._flight.task
        self.stop()
        task.interrupt()
        self._count_idle()
        violated = f"{', '.join(task.violated)} violated" if task.violated else ""
        self._due = (
            why or self._predictions.surprise or flight.failure or violated or "a belief came back"
        )
        self._due_s = flight.now_s
        self._plan_again()

    def _plan_again(self) -> TaskStatus:
        """Makes the plan that is due, once the ways on the map are known; the vehicle holds."""
        flight, task = self._flight, self._flight.task
        if not self._reachability.are_known() and flight.now_s < self._due_s + PATIENCE_S:
            return self.status
        self._reachability.follow()
        problem, histories = task.problem()
        if self._inquiry is not None:
            if self._inquiry.is_about(problem):
                return self._find_out_why(self._inquiry)
            self._count_idle()  # what flaps must not be asked about for ever
        flight.may_do_better = False
        try:
            if self._planner.mission.tree is not None:
                raise NoPlanError("no plan: the mission has a tree of its own")
            if self._idle_replans > MAX_IDLE_REPLANS:
                raise NoPlanError(f"no plan: {MAX_IDLE_REPLANS} plans in a row led nowhere")
            lasso = self._planner.replan(problem, histories)
        except NoPlanError as error:
            return self._give_up(error)
        if lasso is None:
            self._inquiry = ExplanationSearch(self._planner, problem)
            return self._find_out_why(self._inquiry)
        reason, is_kept = self._due, self.lasso is not None and self._is_rest_of(self.lasso, lasso)
        self.failure, self.is_leaving = None, False
        self._adopt(lasso)
        if not is_kept:
            self.replans += 1
            text = f"replan {self.replans}: {reason} -> {lasso}"
            flight.report("replan", text, number=self.replans, reason=reason, **lasso.as_json())
        self._tell_tree()
        return self.status

    def _find_out_why(self, inquiry: ExplanationSearch) -> TaskStatus:
        """Gives up, once it is known why there is no plan."""
        answer = inquiry.step()
        return self._give_up(answer) if answer else self.status

    def _give_up(self, error: NoPlanError) -> TaskStatus:
        reason, self._due, self._inquiry = self._due, "", None
        self.replans += 1
        self.status = TaskStatus.NO_PLAN
        self.failure = error
        text = f"replan {self.replans}: {reason}: {error}"
        self._flight.report("replan", text, reason=reason)
        return self.status

    def _rest(self) -> None:
        """Leaves the last position, which lasts for ever."""
        self._flight.task.leave()
        tell_positions(self._flight, for_ever=True)

    def _tell_tree(self) -> None:
        """Reports what the tree's nodes do now, if it is not what they did."""
        if self._tree_report is not None:
            self._tree_report.tell()

    def _count_idle(self) -> None:
        """Counts replans between which the task's word has not grown."""
        positions = self._flight.task.positions
        self._idle_replans = 0 if positions > self._positions else self._idle_replans + 1
        self._positions = positions

    def _adopt(self, lasso: Lasso) -> None:
        flight = self._flight
        flight.laps = flight.completed = 0
        flight.failure = self._due = ""
        self._inquiry = None
        self.needs_take_off, flight.is_grounded = flight.is_grounded, False
        self.lasso = lasso
        self._predictions.renew()
        self._predictions.narrow(lasso)
        self._root = build(flight, lasso, self._predictions)
        self._tree_report = TreeReport(flight, self._root)

    def _is_still_best(self, lasso: Lasso) -> bool:
        """Whether a plan made now, as from the place left last, is the rest of the present one."""
        new = self._plan_now() if self._flight.task.running is not None else None
        return new is not None and self._is_rest_of(lasso, new)

    def _plan_now(self) -> Lasso | None:
        """The plan that would be made now; None if there is none."""
        try:
            return self._planner.replan(*self._flight.task.problem())
        except NoPlanError:
            return None

    def _is_rest_of(self, lasso: Lasso, new: Lasso) -> bool:
        """Whether a new plan is what is left of another one."""
        return new.names(COMPARED) == lasso.names(COMPARED, self._flight.completed)
