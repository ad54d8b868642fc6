"""Ticks the plan's tree, and plans again when the plan is no longer right (Section III-B).

A plan assumes that every event keeps its value and that every belief holds. When one of these turns
out to be wrong, the executive searches a new lasso from the present state, with the history of the
flight, and builds a new tree. The vehicle holds meanwhile. executive_states.py says what the
executive may be doing. It carries out what deliberation.py decides.

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

from py_trees.behaviour import Behaviour

from companion.acting.behaviour_tree.builder import build
from companion.acting.behaviour_tree.ticked_tree import TickedTree
from companion.acting.deliberation import Deliberation, PlanChosen, PlanDecision
from companion.acting.executive_states import (
    AwaitingPlan,
    ByHand,
    Executing,
    ExecutiveState,
    Grounded,
    Idle,
    InTheAir,
    Leaving,
    Satisfied,
    Searching,
    TaskStatus,
    WithoutPlan,
    WithTree,
)
from companion.acting.flight import Flight
from companion.acting.ground_plans import GroundPlans
from companion.acting.plan_progress import GroundState
from companion.acting.plan_reports import PlanReports
from companion.acting.plan_under_way import (
    LeftPlan,
    LeftSafePlaceFlight,
    LeftTaskPlan,
    PlanUnderWay,
    SafePlaceFlight,
    TaskPlan,
)
from companion.acting.positions import tell_positions
from companion.acting.preparation import PreparedMission
from companion.acting.replanning.optional_lines import drop
from companion.acting.replanning.replanner import PlanFailure, ReplanReason
from companion.acting.waiting_hold import WaitingHold
from companion.acting.whereabouts import Whereabouts
from companion.acting.written_end import failure_at_the_end
from companion.errors import NoPlanError
from companion.flight_events.skills import WrittenTreeFailed
from companion.mission.facts import Fact
from companion.planning.lasso import ChosenPlan, Lasso


class Executive:
    """Acts out one mission.

    Attributes:
        state: what it is doing.
        planner: the mission's planner.
        deliberation: decides about its plans.
        reports: tells and counts them.

    Args:
        prepared: the mission, with its planner and its first plan.
        flight: what the tree acts on.
    """

    def __init__(self, prepared: PreparedMission, flight: Flight) -> None:
        self.state: ExecutiveState = Idle()
        self.planner = planner = prepared.planner
        self._flight = flight
        self.deliberation = Deliberation(planner, flight, prepared.engine)
        self.reports = PlanReports(flight)
        self._ground_plans = GroundPlans(prepared, flight, self.deliberation)
        self._whereabouts = Whereabouts(flight, planner.mission.places)
        self._waiting_hold = WaitingHold(flight)

    @property
    def status(self) -> TaskStatus:
        """The status of the task."""
        return self.state.status

    @property
    def lasso(self) -> Lasso | None:
        """The plan that is flown, or was flown last; None for a tree written by hand."""
        plan = self.state.plan
        return None if plan is None else plan.lasso

    @property
    def failure(self) -> PlanFailure | None:
        """Why the task has no plan, or why none was found; None while there is a plan."""
        return self.state.failure

    @property
    def is_leaving(self) -> bool:
        """Whether it flies to a place because the task has no plan, or has lost its way there."""
        return isinstance(self.state.plan, SafePlaceFlight | LeftSafePlaceFlight)

    @property
    def way_lost(self) -> str | None:
        """Why the flight to a safe place has failed; None if it has not."""
        plan = self.state.plan
        return plan.way_lost if isinstance(plan, LeftSafePlaceFlight) else None

    @property
    def watched(self) -> frozenset[Fact]:
        """The events that the leftmost branch of the tree watches now."""
        is_watching = isinstance(self.state, Executing | Leaving)
        is_watching = is_watching and not self._flight.progress.is_landed_by_plan
        return self.deliberation.assumptions.watched if is_watching else frozenset()

    @property
    def may_have_plan(self) -> bool:
        """Whether it flies a plan for the task, or searches one."""
        return isinstance(self.state, Executing | Searching)

    def plan(self) -> PlanFailure | None:
        """Adopts the first plan, searching one if necessary; returns why there is none, or None."""
        flight, mission = self._flight, self.planner.mission
        if mission.tree is not None:
            self._take_up(ByHand(self._ticked(self._ground_plans.written(mission.tree))))
            return None
        found = self._ground_plans.first()
        if not isinstance(found, ChosenPlan):
            return found
        drop(flight, found.dropped)
        executing = Executing(self._adopt(found.lasso))
        self.reports.tell_made(mission, found)
        self._take_up(executing)
        return None

    def plan_again(self, reason: str) -> PlanFailure | None:
        """Plans again before take-off, for a changed map; returns why there is no plan, or None."""
        found = self._ground_plans.again()
        if isinstance(found, ChosenPlan):
            self._fly_on(self.deliberation.choose(found, reason, self._left()))
            return None
        return found

    def tick(self) -> TaskStatus:
        """Does the work of one tick; returns the status of the task."""
        if isinstance(self.state, Grounded):  # and has taken off since
            self.state = self.state.then
        lost = None if self.is_leaving else self._whereabouts.look()
        match self.state:
            case Executing(plan) if lost is not None:
                self._replan(f"no longer at {lost.place}", plan.left)
            case Executing(plan) | Leaving(plan):
                self._tick_plan(plan)
            case ByHand(tree):
                self._tick_by_hand(tree)
            case Searching() as search:
                self._flight.guidance.hold()
                self._follow(self.deliberation.search(search))
            case AwaitingPlan() as waiting:
                self._waiting_hold.tick(waiting.hopes)
                self._follow(self.deliberation.wait(waiting))
        return self.status

    def leave(self, lasso: Lasso) -> None:
        """Flies to a safe place because the task has no plan."""
        flight, failure = self._flight, self.failure
        flight.task.interrupt()
        flight.task.depart()
        tell_positions(flight)
        self.deliberation.assumptions.renew()
        is_landed = flight.progress.is_landed_by_plan
        self.deliberation.adopt(lasso)
        flown = SafePlaceFlight(lasso, self._ticked(build(flight, lasso, None)))
        self._take_up(Leaving(flown, failure), is_landed)

    def stop(self) -> None:
        """Ends the plan, and the search for another one; the vehicle holds."""
        self.deliberation.abandon()
        if isinstance(self.state, WithTree):
            self.state.tree.stop()
        self._flight.guidance.hold()

    def pause(self) -> None:
        """Interrupts the plan or the tree, to continue it later; the vehicle holds."""
        if isinstance(self.state, ByHand):
            self.state.tree.pause()
            self._flight.guidance.hold()
        else:
            self.stop()

    def resume(self) -> TaskStatus:
        """Continues after a pause: with a new plan from here, or with the tree written by hand."""
        self._whereabouts.look_after_absence()
        if isinstance(self.state, ByHand):
            self.state.tree.resume()
        elif self.planner.mission.tree is None:
            self.deliberation.replanner.start_over()
            self._replan("going on", self._left())
        return self.status

    def _tick_plan(self, plan: PlanUnderWay) -> None:
        triggers, progress = self.deliberation.triggers, self._flight.progress
        laps, task_laps = progress.laps, self._flight.task.word.laps
        triggers.look(plan)
        if reason := triggers.before_the_tree(plan):
            self._replan(reason, plan.left)
            return
        plan.tree.tick()
        plan.tree.tell()
        tell_positions(self._flight)
        if isinstance(plan, TaskPlan) and not plan.lasso.ends_at_rest:
            self.reports.tell_laps(self._flight.task.word.laps - task_laps)
        is_over = progress.laps > laps and plan.lasso.ends_at_rest
        if is_over:
            self._flight.task.leave()
        if reason := triggers.after_the_tree(plan):
            tell_positions(self._flight)
            self._replan(reason, plan.left)
        elif is_over:
            self._rest()
            self.state = Satisfied(plan, self.failure)

    def _tick_by_hand(self, tree: TickedTree) -> None:
        """One tick of a tree that was written by hand: it is not replaced when it fails.

        After a skill has failed on the ground, it continues in the air, as a new plan would.
        """
        flight = self._flight
        task_laps = flight.task.word.laps
        tree.tick()
        flight.hold_unless_commanded()
        tree.tell()
        tell_positions(flight)
        self.reports.laps += flight.task.word.laps - task_laps
        if tree.has_succeeded:
            self._rest()
            self.state = Satisfied(None, failure_at_the_end(flight.task))
        elif tree.has_failed:
            flight.task.interrupt()
            failed = WrittenTreeFailed(tree.failure)
            self.state = WithoutPlan(None, NoPlanError(failed.text), failed.text)
            flight.report(failed)
        elif flight.progress.ground is GroundState.STRANDED:
            flight.progress.leave_ground()
            self.state = Grounded(ByHand(tree))

    def _rest(self) -> None:
        """Leaves the last position, which lasts for ever."""
        self._flight.task.leave()
        tell_positions(self._flight, for_ever=True)

    def _replan(self, reason: ReplanReason, left: LeftPlan | None) -> None:
        self.stop()
        self._flight.task.interrupt()
        self._follow(self.deliberation.replan(reason, left, self.failure))

    def _follow(self, decision: PlanDecision) -> None:
        """Carries out a decision."""
        match decision:
            case PlanChosen():
                self._fly_on(decision)
                return
            case AwaitingPlan() if self.failure is None:
                self.reports.tell_awaited(decision)
            case WithoutPlan():
                self.reports.tell_not_found(decision)
        self.state = decision

    def _fly_on(self, chosen: PlanChosen) -> None:
        """Adopts a new plan; reports it unless it is just the rest of the old one."""
        flight, plan = self._flight, chosen.plan
        drop(flight, plan.dropped)
        is_landed = flight.progress.is_landed_by_plan
        executing = Executing(self._adopt(plan.lasso))
        if not chosen.is_rest:
            self.reports.tell_replaced(chosen.reason, plan)
        self._take_up(executing, is_landed)

    def _adopt(self, lasso: Lasso) -> TaskPlan:
        """Begins a plan for the task, whose assumptions are already noted."""
        self.deliberation.adopt(lasso)
        root = build(self._flight, lasso, self.deliberation.assumptions)
        return TaskPlan(lasso, self._ticked(root))

    def _ticked(self, root: Behaviour) -> TickedTree:
        return TickedTree(self._flight, root)

    def _take_up(self, state: InTheAir, is_landed: bool = False) -> None:
        """Ticks a tree from now on, or once the vehicle has taken off."""
        self.state = Grounded(state) if is_landed else state
        state.tree.tell()

    def _left(self) -> LeftPlan | None:
        """The plan that is left, for a plan for the task."""
        return None if self.lasso is None else LeftTaskPlan(self.lasso)
