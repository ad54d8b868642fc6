"""The reasons to plan again that are looked at before the plan's tree is ticked.

They are what the map, the charge, the beliefs and the clocks say, which the tree acts on.
`replan_triggers.py` says which of them are asked about a flight to a safe place.
"""

from __future__ import annotations

from companion.acting.charge.energy_watch import EnergyWatch
from companion.acting.flight import Flight
from companion.acting.plan_under_way import PlanUnderWay, SafePlaceFlight
from companion.acting.replanning.assumptions import BELIEF_CAME_BACK, Assumptions
from companion.acting.replanning.late_plans import LatePlans
from companion.acting.replanning.replanner import BetterPlan, Replanner
from companion.acting.triggers.trigger import ReplanTrigger, SlicedTrigger
from companion.planning.domain import Action, is_one_flight
from companion.slices import Question

LOOKS_AT_FLIGHT_S, LOOKS_AT_SKILL_S = 1.0, 0.25
"""How often a flight, or a skill that works longer than its cost, is compared with time bounds."""

SLOW_S = 0.3
"""A flight is compared with them if it will end so much later than planned; finding out how much
exactly takes milliseconds."""


class CutOffByMap(SlicedTrigger[str | None]):
    """A belief that the plan needs was given up, once the routes on the map are known.

    A flight to a safe place needs none; in it, the beliefs are given up, and that is all.

    Args:
        flight: knows the progress of the plan.
        replanner: knows the map.
        outdated: the question that is dropped when this trigger takes over the map.
    """

    def __init__(
        self, flight: Flight, replanner: Replanner, outdated: Question[BetterPlan | None]
    ) -> None:
        super().__init__()
        self._flight, self._replanner, self._outdated = flight, replanner, outdated

    def guard(self, plan: PlanUnderWay) -> bool:
        """The map has changed, and what it has changed is not known yet."""
        is_news = self._replanner.reachability.has_changed or self.is_thinking
        return is_news and not self._flight.progress.is_landed_by_plan

    def reason(self, plan: PlanUnderWay) -> str | None:
        """The beliefs that were given up, unless the plan is still the best one."""
        self._outdated.abandon()
        reachability = self._replanner.reachability
        reachability.search()
        if not reachability.is_known:
            return None

        def reason() -> str | None:
            cut_off = self._replanner.follow_map()
            if cut_off is None or isinstance(plan, SafePlaceFlight):
                return None
            if self._replanner.search_confirms(plan.lasso):
                return None
            return cut_off.text

        answered = self._question.ask("the map", reason)
        return answered.answer if answered else None


class ChargeShort(ReplanTrigger):
    """The charge is not enough for the rest of the plan.

    Args:
        flight: knows the progress of the plan.
        energy: checks the charge.
    """

    def __init__(self, flight: Flight, energy: EnergyWatch) -> None:
        self._flight, self._energy = flight, energy

    def guard(self, plan: PlanUnderWay) -> bool:
        """It is time for a check, in the air."""
        return self._energy.is_due and not self._flight.progress.is_landed_by_plan

    def reason(self, plan: PlanUnderWay) -> str | None:
        """What is missing."""
        return self._energy.shortage()


class EnergyFigureWrong(SlicedTrigger[str | None]):
    """Flights take another energy than plans assume.

    If they take less, the charge lasts for the plan: it is kept if there is no other one.

    Args:
        flight: knows the progress of the plan.
        energy: measures the energy of flights.
        replanner: plans with the new figure.
    """

    def __init__(self, flight: Flight, energy: EnergyWatch, replanner: Replanner) -> None:
        super().__init__()
        self._flight, self._energy, self._replanner = flight, energy, replanner

    def guard(self, plan: PlanUnderWay) -> bool:
        """The figure is wrong."""
        is_wrong = self.is_thinking or self._energy.is_figure_wrong
        return is_wrong and not self._flight.progress.is_landed_by_plan

    def reason(self, plan: PlanUnderWay) -> str | None:
        """The new figure, which plans use from now on."""
        energy = self._energy

        def reason() -> str | None:
            does_last, figure = not energy.takes_more, energy.take_factor()
            return None if does_last and self._replanner.plan_now() is None else figure

        answered = self._question.ask(plan.lasso, reason)
        return answered.answer if answered else None


class TaskPossibleAgain(SlicedTrigger[bool]):
    """The task has a plan again, while the vehicle flies to a safe place without one.

    The flight continues during the search.

    Args:
        flight: knows the task.
        assumptions: know which beliefs have come back, and which events have changed.
        replanner: searches for a plan.
    """

    def __init__(self, flight: Flight, assumptions: Assumptions, replanner: Replanner) -> None:
        super().__init__()
        self._flight, self._assumptions, self._replanner = flight, assumptions, replanner

    def guard(self, plan: PlanUnderWay) -> bool:
        """Beliefs have come back, or events have changed."""
        assumptions = self._assumptions
        return assumptions.may_do_better or bool(assumptions.wrong)

    def reason(self, plan: PlanUnderWay) -> str | None:
        """What has changed, if there is a plan now."""
        task = self._flight.task
        if not task.violated:
            about = tuple(self._assumptions.wrong), task.withdrawn
            answered = self._question.ask(about, lambda: self._replanner.is_possible)
            if answered is None:
                return None
            if answered.answer:
                return self._assumptions.surprise or BELIEF_CAME_BACK
        self._assumptions.forget_restored_beliefs()
        self._assumptions.renew()
        return None


class DroppedLineKept(SlicedTrigger[str | None]):
    """A line of the task that was dropped can be kept; asked once after each completed skill.

    Changes of an event do not ask again. Those that matter to the plan lead to another one, which
    considers all lines.

    Args:
        flight: knows the task.
        replanner: searches for a plan with the line.
    """

    def __init__(self, flight: Flight, replanner: Replanner) -> None:
        super().__init__()
        self._flight, self._replanner = flight, replanner

    def guard(self, plan: PlanUnderWay) -> bool:
        """A skill was completed, and lines are dropped."""
        return self._flight.task.lines.may_take_up and not self._flight.progress.is_landed_by_plan

    def reason(self, plan: PlanUnderWay) -> str | None:
        """The line."""
        task = self._flight.task
        if isinstance(plan, SafePlaceFlight):
            task.keep_dropped()
            return None
        answered = self._question.ask(task.completed, lambda: self._replanner.line_to_take_up)
        if answered is None:
            return None
        task.keep_dropped()
        return None if answered.answer is None else f"{answered.answer} has a plan again"


class BoundLate(SlicedTrigger[BetterPlan | None]):
    """A time bound will be late, and another plan keeps it.

    It is asked when an action has begun, and then again and again while that takes longer than
    planned.

    Args:
        flight: knows the progress of the plan.
        late_plans: compares the plan with others.
        cut_off: it waits for this trigger, which takes over the map.
        question: its question.
    """

    def __init__(
        self,
        flight: Flight,
        late_plans: LatePlans,
        cut_off: CutOffByMap,
        question: Question[BetterPlan | None],
    ) -> None:
        super().__init__(question)
        self._flight, self._late_plans, self._cut_off = flight, late_plans, cut_off
        self._begun: tuple[PlanUnderWay, int] | None = None
        self._begun_s = self._looked_s = 0.0
        self._is_answered = False

    def guard(self, plan: PlanUnderWay) -> bool:
        """An action is under way that has just begun, or that may take longer than planned."""
        running, progress = self._flight.task.running, self._flight.progress
        if running is None or progress.is_landed_by_plan:
            return False
        if not self._late_plans.are_possible or self._cut_off.guard(plan):
            return False
        is_news = self._begun != (plan, progress.completed) or not self._is_answered
        return is_news or self.is_thinking or self._is_due(running)

    def _is_due(self, running: Action) -> bool:
        """Whether to look again at an action that has begun."""
        now_s = self._flight.now_s
        planned_s = self._begun_s + running.cost_ms / 1000
        if is_one_flight(running.execute):
            ends_s = self._flight.progress.flight_ends_s or now_s
            return ends_s > planned_s + SLOW_S and now_s - self._looked_s >= LOOKS_AT_FLIGHT_S
        return now_s > planned_s and now_s - self._looked_s >= LOOKS_AT_SKILL_S

    def reason(self, plan: PlanUnderWay) -> BetterPlan | None:
        """The other plan."""
        now_s, late_plans = self._flight.now_s, self._late_plans
        action = plan, self._flight.progress.completed
        if self._begun != action:
            self._begun, self._begun_s, self._is_answered = action, now_s, False
        if self._is_answered:
            elapsed_s = now_s - self._begun_s
            about, think = (*action, True), lambda: late_plans.under_way(plan.lasso, elapsed_s)
        else:
            about, think = (*action, False), lambda: late_plans.from_the_beginning(plan.lasso)
        answered = self._question.ask(about, think)
        if answered is None:
            return None
        self._is_answered, self._looked_s = True, now_s
        return answered.answer
