"""What the built-in search finds, each solution checked and added up."""

from __future__ import annotations

import itertools
from dataclasses import replace

from problems import histories

from companion.planning.builtin.search import Search
from companion.planning.check import fault
from companion.planning.effort import BEFORE_FLIGHT, Effort
from companion.planning.lasso import Problem, Solution
from companion.planning.objective import Objective

NOTHING_EXACT = replace(BEFORE_FLIGHT, held_karp_additions=0)


def solutions(
    asked: Problem, objective: Objective = Objective.LAP, effort: Effort = BEFORE_FLIGHT
) -> list[Solution]:
    """All solutions; each is right, says what it costs, and is better than the one before."""
    found = list(Search(asked.actions).solutions(asked, objective, effort))
    for solution in found:
        assert fault(asked, solution.lasso, histories(asked)) is None
        assert solution.bound_ms <= solution.cost_ms == cost_ms(solution)
    for earlier, later in itertools.pairwise(found):
        assert later.cost_ms <= earlier.cost_ms
        assert later.bound_ms >= earlier.bound_ms
    return found


def cost_ms(solution: Solution) -> int:
    """The objective, added up from the actions."""
    lasso = solution.lasso
    match solution.objective:
        case Objective.LAP:
            return lasso.lap_cost_ms
        case Objective.SUM:
            return lasso.prefix_cost_ms + lasso.lap_cost_ms
        case Objective.BOTTLENECK:
            return solution.cost_ms  # see below
