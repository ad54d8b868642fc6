"""Ticks the plan's tree, and plans again when the plan is no longer right (Section III-B).

A plan assumes that every event keeps its value and that every belief holds. When one of these turns
out to be wrong, the executive searches a new lasso from the present state, with the history of the
flight, and builds a new tree. The vehicle holds meanwhile. `ExecutiveState` says what the executive
is doing; the table in replan_triggers.py lists the reasons for a new plan.

Plans change as little as possible. If an event matters, but the rest of the plan is still the best
one, the plan stays. If a belief comes back, or a dropped line of the task can be kept again, a new
plan is made at the next completed skill.

A plan that ends at rest satisfies the task when the vehicle rests. Each position of the word is
reported when the vehicle leaves it, with the conjuncts that it violates. Without a plan the
vehicle holds, as long as one may become possible again (replanning/patience.py). After a violation
a plan is searched once more; there is none if the violated line may not be dropped. On the way home
after that, the only events that count are those by which all violated lines start again.
"""

from __future__ import annotations

from collections.abc import Sequence

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from companion.acting.behaviour_tree import pausing
from companion.acting.behaviour_tree.builder import build
from companion.acting.behaviour_tree.leaf import failure_of
from companion.acting.behaviour_tree.tree_report import TreeReport
from companion.acting.event_detector import EventDetector
from companion.acting.executive_states import FLIES_BY_PLAN, STATUS, ExecutiveState, TaskStatus
from companion.acting.flight import Flight
from companion.acting.ground_plans import GroundPlans
from companion.acting.plan_progress import GroundState, PlanProgress
from companion.acting.plan_reports import tell_made, tell_replaced
from companion.acting.positions import tell_positions
from companion.acting.preparation import PreparedMission
from companion.acting.replan_triggers import PlanUnderWay, ReplanTriggers
from companion.acting.replanning.assumptions import Assumptions
from companion.acting.replanning.optional_lines import drop
from companion.acting.replanning.patience import Patience
from companion.acting.replanning.replanner import DueReplan, PlanFailure, Replanner
from companion.acting.safe_places import flight_to
from companion.acting.whereabouts import Whereabouts
from companion.acting.written_end import failure_at_the_end
from companion.errors import NoPlanError
from companion.flight_events.facts import BeliefRestored, MissionEventChanged
from companion.flight_events.plans import LapCompleted, NoPlanFound
from companion.flight_events.skills import WrittenTreeFailed
from companion.mission.facts import Fact
from companion.mission.signals import Signal
from companion.planning.lasso import ChosenPlan, Lasso


class Executive:
    """Acts out one mission.

    Attributes:
        state: what it is doing.
        replans: number of replans.
        planner: the mission's planner.
        due: the replan that is due, or was due last; None before the first one.
        lasso: the present plan; None before the first, and with a tree written by hand.
        failure: why the task has no plan, or why none was found; None while there is a plan.
        has_lost_way: whether a flight to a safe place, without a plan for the task, has failed.

    Args:
        prepared: the mission, with its planner and its first plan.
        flight: what the tree acts on.
        detector: detects the mission's events.
    """

    def __init__(self, prepared: PreparedMission, flight: Flight, detector: EventDetector) -> None:
        self.state = ExecutiveState.IDLE
        self.replans = 0
        self.lasso: Lasso | None = None
        self.failure: PlanFailure | None = None
        self.due: DueReplan | None = None
        self.has_lost_way = False
        self.planner = planner = prepared.planner
        self._flight = flight
        self._detector = detector
        self._root: Behaviour | None = None
        self._tree_report: TreeReport | None = None
        self._assumptions = Assumptions(planner, flight)
        self._patience = Patience(planner, flight)
        self._replanner = Replanner(
            planner, flight, self._assumptions, self._patience, prepared.engine
        )
        self._ground_plans = GroundPlans(prepared, flight, self._assumptions, self._replanner)
        self._triggers = ReplanTriggers(
            flight, self._assumptions, self._replanner, energy=planner.energy
        )
        self._whereabouts = Whereabouts(flight, planner.mission.places)
        self._plan_state = ExecutiveState.EXECUTING
        self._paused_s = 0.0

    @property
    def status(self) -> TaskStatus:
        """The status of the task."""
        return STATUS.get(self.state, TaskStatus.RUNNING)

    def sense(self, readings: Sequence[tuple[Signal, float]]) -> None:
        """Takes received readings and turns them into facts."""
        flight, events = self._flight, self.planner.mission.events
        restores: frozenset[str] = frozenset()
        for name, holds in self._detector.update(flight.now_s, flight.hear(readings)):
            flight.task.take(events[name], holds)
            flight.report(MissionEventChanged(name, holds))
            restores |= events[name].restores if holds else frozenset()
        for belief in flight.task.restore(flight.now_s, self.state not in FLIES_BY_PLAN, restores):
            flight.report(BeliefRestored(belief))
            self._assumptions.note_restored_beliefs()

    def plan(self) -> PlanFailure | None:
        """Adopts the first plan, searching one if necessary; returns why there is none, or None."""
        flight, mission = self._flight, self.planner.mission
        if mission.tree is not None:
            self._plan_state = ExecutiveState.BY_HAND
            self._take_tree(self._ground_plans.written(mission.tree), ExecutiveState.BY_HAND)
        else:
            found = self._ground_plans.first()
            if not isinstance(found, ChosenPlan):
                return found
            drop(flight, found.dropped)
            self._adopt(found.lasso, ExecutiveState.EXECUTING)
            tell_made(flight, mission, found)
        self._tell_tree()
        return None

    def plan_again(self, reason: str) -> PlanFailure | None:
        """Plans again before take-off, for a changed map; returns why there is no plan, or None."""
        found = self._ground_plans.again()
        if isinstance(found, ChosenPlan):
            self._fly_on(found, reason)
            return None
        return found

    def tick(self) -> TaskStatus:
        """Does the work of one tick; returns the status of the task."""
        if self.state is ExecutiveState.GROUNDED:  # and has taken off since
            self.state = self._plan_state
        lost = None if self.is_leaving else self._whereabouts.look()
        if lost is not None and self.state is ExecutiveState.EXECUTING:
            self._replan(f"no longer at {lost.place}")
            return self.status
        match self.state:
            case ExecutiveState.EXECUTING | ExecutiveState.LEAVING:
                assert self.lasso is not None and self._root is not None
                self._tick_plan(PlanUnderWay(self.lasso, self._root, self.is_leaving))
            case ExecutiveState.BY_HAND:
                assert self._root is not None
                self._tick_by_hand(self._root)
            case ExecutiveState.REPLANNING | ExecutiveState.EXPLAINING:
                assert self.due is not None
                self._flight.guidance.hold()
                self._plan_again(self.due)
            case ExecutiveState.AWAITING_PLAN:
                assert self.due is not None and self.failure is not None
                self._patience.hold()
                self._wait(self.failure, self.due)
        return self.status

    @property
    def watched(self) -> frozenset[Fact]:
        """The events that the leftmost branch of the tree watches now."""
        is_watching = self.state in (ExecutiveState.EXECUTING, ExecutiveState.LEAVING)
        is_watching = is_watching and not self._flight.progress.is_landed_by_plan
        return self._assumptions.watched if is_watching else frozenset()

    def go_to(self, place: str) -> bool:
        """Flies to a place because the task has no plan; False if no route leads there."""
        self._flight.task.interrupt()
        lasso = flight_to(self.planner, place)
        if lasso is None:
            return False
        self._flight.task.depart()
        tell_positions(self._flight)
        self._assumptions.renew()
        self._adopt(lasso, ExecutiveState.LEAVING)
        self._tell_tree()
        return True

    @property
    def is_leaving(self) -> bool:
        """Whether it flies to a place because the task has no plan, or has lost its way there."""
        return self._plan_state is ExecutiveState.LEAVING

    def stop(self) -> None:
        """Ends the plan, and the search for another one; the vehicle holds."""
        self._replanner.abandon()
        self._triggers.abandon()
        if self._root is not None:
            self._root.stop(Status.INVALID)
            self._tell_tree()
        self._flight.guidance.hold()

    def pause(self) -> None:
        """Interrupts the plan or the tree, to continue it later; the vehicle holds."""
        if self.state is ExecutiveState.BY_HAND and self._root is not None:
            self._paused_s = self._flight.now_s
            pausing.pause(self._root)
            self._tell_tree()
            self._flight.guidance.hold()
        else:
            self.stop()

    def resume(self) -> TaskStatus:
        """Continues after a pause: with a new plan from here, or with the tree written by hand."""
        self._whereabouts.look_after_absence()
        if self.state is ExecutiveState.BY_HAND and self._root is not None:
            pausing.resume(self._root, self._flight.now_s - self._paused_s)
        elif self.planner.mission.tree is None:
            self._plan_state = ExecutiveState.EXECUTING
            self._replanner.forgive()
            self._replan("going on")
        return self.status

    def _tick_plan(self, plan: PlanUnderWay) -> None:
        progress = self._flight.progress
        laps = progress.laps
        self._triggers.look(plan)
        if reason := self._triggers.before_the_tree(plan):
            self._replan(reason)
            return
        plan.tree.tick_once()
        self.has_lost_way = plan.is_leaving and plan.tree.status is Status.FAILURE
        self._tell_tree()
        tell_positions(self._flight)
        is_lap_done = progress.laps > laps
        is_over = is_lap_done and plan.lasso.ends_at_rest
        if is_over:
            self._flight.task.leave()
        if reason := self._triggers.after_the_tree(plan):
            tell_positions(self._flight)
            self._replan(reason)
        elif is_over:
            self._rest()
        elif is_lap_done:
            self._flight.report(LapCompleted(progress.laps))

    def _tick_by_hand(self, root: Behaviour) -> None:
        """One tick of a tree that was written by hand: it is not replaced when it fails.

        After a skill has failed on the ground, it continues in the air, as a new plan would.
        """
        root.tick_once()
        self._flight.hold_unless_told()
        self._tell_tree()
        tell_positions(self._flight)
        if root.status is Status.SUCCESS:
            self._rest()
            self.failure = failure_at_the_end(self._flight.task)
        elif root.status is Status.FAILURE:
            self._flight.task.interrupt()
            self.state = ExecutiveState.WITHOUT_PLAN
            failed = WrittenTreeFailed(failure_of(root))
            self.failure = NoPlanError(failed.text)
            self._flight.report(failed)
        elif self._flight.progress.ground is GroundState.STRANDED:
            self._flight.progress.leave_ground()
            self.state = ExecutiveState.GROUNDED

    # -- planning again ------------------------------------------------------------------------

    def _replan(self, reason: str) -> None:
        self.stop()
        self._flight.task.interrupt()
        self.due = self._replanner.begin(reason)
        if self._triggers.has_used_slice:
            self.state = ExecutiveState.REPLANNING
        else:
            self._plan_again(self.due)

    def _plan_again(self, due: DueReplan) -> None:
        """A part of making the plan that is due."""
        match self._replanner.step(due):
            case None:
                is_explaining, states = self._replanner.is_explaining, ExecutiveState
                self.state = states.EXPLAINING if is_explaining else states.REPLANNING
            case ChosenPlan() as plan:
                self._fly_on(plan, due.reason)
            case failure:
                self._wait_or_give_up(failure, due.left_for)

    def _fly_on(self, plan: ChosenPlan, reason: str) -> None:
        """Adopts a new plan; reports it unless it is just the rest of the old one."""
        lasso = plan.lasso
        drop(self._flight, plan.dropped)
        is_kept = self.lasso is not None and self._replanner.is_rest_of(self.lasso, lasso)
        self.failure = None
        self._adopt(lasso, ExecutiveState.EXECUTING, self._flight.progress.laps if is_kept else 0)
        if not is_kept:
            self.replans += 1
            tell_replaced(self._flight, self.replans, reason, plan)
        self._tell_tree()

    def _wait_or_give_up(self, failure: PlanFailure, reason: str) -> None:
        """Holds and searches again, as long as a plan may become possible; then gives up."""
        patience, is_news = self._patience, self.failure is None
        self.failure = failure
        if not patience.lasts:
            self._give_up(failure, reason)
            return
        self.state = ExecutiveState.AWAITING_PLAN
        if is_news:
            patience.tell(failure)

    def _wait(self, failure: PlanFailure, due: DueReplan) -> None:
        """A tick without a plan."""
        if not self._patience.lasts:
            self._give_up(failure, due.left_for)
        elif news := self._replanner.looks_again():
            self._replanner.forgive()
            self.due = self._replanner.begin(news, due.left_for)
            self._plan_again(self.due)

    def _give_up(self, failure: PlanFailure, reason: str) -> None:
        self.replans += 1
        self.state = ExecutiveState.WITHOUT_PLAN
        self.failure = failure
        self._flight.report(NoPlanFound(self.replans, reason, str(failure)))

    def _adopt(self, lasso: Lasso, state: ExecutiveState, laps: int = 0) -> None:
        """Ticks the tree of a plan from now on; its assumptions are already noted."""
        flight = self._flight
        is_landed = flight.progress.is_landed_by_plan
        flight.progress = PlanProgress(laps=laps)
        self.lasso = lasso
        self._triggers.adopt(lasso)
        self._plan_state = state
        relied_on = None if state is ExecutiveState.LEAVING else self._assumptions
        root = build(flight, lasso, relied_on)
        self._take_tree(root, ExecutiveState.GROUNDED if is_landed else state)

    def _take_tree(self, root: Behaviour, state: ExecutiveState) -> None:
        self.state, self._root = state, root
        self._tree_report = TreeReport(self._flight, root)

    def _rest(self) -> None:
        """Leaves the last position, which lasts for ever."""
        self.state = ExecutiveState.SATISFIED
        self._flight.task.leave()
        tell_positions(self._flight, for_ever=True)

    def _tell_tree(self) -> None:
        """Reports changes in the status of the tree's nodes."""
        if self._tree_report is not None:
            self._tree_report.tell()
