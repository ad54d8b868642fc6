"""Why has the task no plan, asked in flight?

The answer takes a search per conjunct and per withdrawn belief: 0.3 s with 20 sites, too long for
setpoints to wait. So it is found in parts, one in each tick, while the vehicle holds.
"""

from __future__ import annotations

from itertools import islice

from companion.planning.explain import NoPlan
from companion.planning.lasso import Problem
from companion.planning.planner import Planner

SEARCHES_PER_TICK = 2
"""One takes 4 ms with 20 sites."""


class Inquiry:
    """Finds out why a problem has no plan.

    Args:
        planner: has found none.
        problem: from where.
    """

    def __init__(self, planner: Planner, problem: Problem) -> None:
        self._problem = problem
        self._parts = planner.reasons(problem)

    def is_about(self, problem: Problem) -> bool:
        """Whether a problem is the same, as far as it decides on whether there is a plan.

        Positions and costs do not.
        """
        mine = self._problem
        return (mine.facts, mine.withdrawn) == (problem.facts, problem.withdrawn) and (
            mine.automaton_states == problem.automaton_states
        )

    def step(self) -> NoPlan | None:
        """The part of a tick; the answer with the last one."""
        for explanation in islice(self._parts, SEARCHES_PER_TICK):
            if explanation is not None:
                return NoPlan(explanation)
        return None
