"""Decides which plan is flown: whether the present one stays, and what follows if it does not.

A deliberation decides, and flies nothing: it ticks no tree and makes no setpoint. The executive
carries its decisions out in flight. A hypothetical flight (contingencies/) asks it before a flight,
so the table of contingencies says what the flight would do.

1. While a plan is flown, `triggers` says why another one is due.
2. `replan` begins a search, and `search` does a slice of it. They return a plan, or that the search
   goes on, or that the vehicle waits for a plan, or that there is none.
3. `wait` decides, in each tick of a wait, whether it goes on, ends, or searches again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from companion.acting.executive_states import AwaitingPlan, Searching, WithoutPlan
from companion.acting.flight import Flight
from companion.acting.plan_progress import PlanProgress
from companion.acting.plan_under_way import LeftPlan
from companion.acting.replan_triggers import ReplanTriggers
from companion.acting.replanning.assumptions import Assumptions
from companion.acting.replanning.patience import Patience
from companion.acting.replanning.replanner import PlanFailure, Replanner, ReplanReason
from companion.planning.engine_port import Engine
from companion.planning.explain import Explanation
from companion.planning.lasso import ChosenPlan, Lasso, Problem
from companion.planning.planner import Planner


@dataclass(frozen=True, slots=True)
class PlanChosen:
    """A plan is flown from now on.

    Attributes:
        plan: the plan, with the lines that it drops.
        reason: why it was made.
        is_rest: whether it is just the rest of the plan before, which so continues.
    """

    plan: ChosenPlan
    reason: str
    is_rest: bool


PlanDecision = PlanChosen | Searching | AwaitingPlan | WithoutPlan


class Deliberation:
    """The decisions about the plans of one flight.

    Attributes:
        assumptions: the assumptions of the plan that is flown.
        triggers: why it has to be replaced.
        replanner: makes plans on the present map.

    Args:
        planner: the mission's planner.
        flight: plans begin at its present state.
        engine: the planner to use; None for the built-in search.
        explain: explains why a problem has no plan; None for the planner's own explanation.
    """

    def __init__(
        self,
        planner: Planner,
        flight: Flight,
        engine: Engine | None = None,
        explain: Callable[[Problem], Explanation] | None = None,
    ) -> None:
        self._flight = flight
        self._patience = Patience(planner, flight)
        self.assumptions = Assumptions(planner, flight)
        self.replanner = Replanner(
            planner, flight, self.assumptions, self._patience, engine, explain
        )
        self.triggers = ReplanTriggers(planner, flight, self.assumptions, self.replanner)

    def adopt(self, lasso: Lasso) -> None:
        """Begins to follow a plan, whose assumptions are noted."""
        self._flight.progress = PlanProgress()
        self.triggers.adopt(lasso)

    def abandon(self) -> None:
        """Ends the search for a plan, and all questions about the present one."""
        self.replanner.abandon()
        self.triggers.abandon()

    def replan(
        self, reason: ReplanReason, left: LeftPlan | None, failure: PlanFailure | None = None
    ) -> PlanDecision:
        """Begins to search another plan, with the rest of this tick's slice.

        Args:
            reason: why, or the plan to change to, if that is known.
            left: the plan that was left; None if another process has flown it.
            failure: why there was no plan before; None if there was one.
        """
        search = Searching(self.replanner.begin(reason), left, failure)
        return search if self.triggers.has_used_slice else self.search(search)

    def search(self, search: Searching) -> PlanDecision:
        """Searches for one slice."""
        match self.replanner.step(search.due):
            case None:
                return replace(search, is_explaining=self.replanner.is_explaining)
            case ChosenPlan() as plan:
                return self.choose(plan, search.due.reason, search.plan)
            case failure:
                return self._without_plan(search, failure)

    def choose(self, plan: ChosenPlan, reason: str, left: LeftPlan | None) -> PlanChosen:
        """Compares a plan that was made with the one before."""
        is_rest = left is not None and self.replanner.is_rest_of(left.lasso, plan.lasso)
        return PlanChosen(plan, reason, is_rest)

    def _without_plan(self, search: Searching, failure: PlanFailure) -> PlanDecision:
        """Waits, as long as a plan may become possible."""
        patience = self._patience
        if not patience.lasts:
            return WithoutPlan(search.plan, failure, search.due.left_for)
        return AwaitingPlan(
            search.due, search.plan, failure, tuple(patience.hopes), patience.left_s
        )

    def wait(self, waiting: AwaitingPlan) -> PlanDecision:
        """Decides in a tick without a plan whether to wait on."""
        if not self._patience.lasts:
            return WithoutPlan(waiting.plan, waiting.failure, waiting.due.left_for)
        news = self.replanner.looks_again()
        return waiting if news is None else self.search_again(waiting, news)

    def search_again(self, waiting: AwaitingPlan, news: str) -> PlanDecision:
        """Searches again, because something has changed; earlier plans may have led nowhere."""
        self.replanner.start_over()
        due = self.replanner.begin(news, waiting.due.left_for)
        return self.search(Searching(due, waiting.plan, waiting.failure))
