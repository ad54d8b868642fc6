"""The search in flight for the reason why a task has no plan.

The answer takes a search per conjunct and per withdrawn belief: 0.3 s with 20 sites, too long for
setpoints to wait. So it is found in parts, a few searches in each tick, while the vehicle holds.
"""

from __future__ import annotations

from itertools import islice

from companion.planning.explain import NoPlan
from companion.planning.lasso import Problem
from companion.planning.planner import Planner

SEARCHES_PER_TICK = 2
"""One takes 4 ms with 20 sites."""


class ExplanationSearch:
    """Finds out why a problem has no plan.

    Args:
        planner: has found none.
        problem: from where.
    """

    def __init__(self, planner: Planner, problem: Problem) -> None:
        self._about = what_decides(problem)
        self._parts = planner.reasons(problem)

    def is_about(self, problem: Problem) -> bool:
        """Whether a problem differs from this one in nothing but costs, which change in the air."""
        return self._about == what_decides(problem)

    def step(self) -> NoPlan | None:
        """The part of a tick; the answer with the last one."""
        for explanation in islice(self._parts, SEARCHES_PER_TICK):
            if explanation is not None:
                return NoPlan(explanation)
        return None


def what_decides(problem: Problem) -> tuple[object, ...]:
    """All of a problem that decides on whether there is a plan."""
    actions = tuple(action.name for action in problem.actions)
    return actions, problem.facts, problem.withdrawn, problem.automaton_states
