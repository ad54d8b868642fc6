"""The built-in search: the best lasso of a problem, or a good one with a bound.

A mission that loops for ever pays for the lap for ever. So by default the shortest lap comes first,
then the shortest prefix for it. The sum of prefix and lap, which a classical planner minimises on
the paper's compilation (Figs. 2-4), gives a lap of 80 on the paper's mission where one of 68
exists.

1. A loop lies in a strongly connected component of the product that has every mark.
2. In each such component the marks that every loop meets anyway are dropped. If none is left, the
   best loop is the shortest cycle (rest, for a task that ends). Otherwise it is the shortest tour
   over targets of the marks, or a good one if there are many (`gtsp.py`).
3. A prefix leads to any node of a best loop, or to another state from which the loop is accepted
   (`loop_entry.py`). Ties are broken by the order of the actions.

`Search` keeps what does not change between plans: the actions as bits, and the automata under the
constants that it has met. In flight only the facts and the states of the automata change.
"""

from __future__ import annotations

import logging
import sys
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from companion.errors import SearchLimit
from companion.planning.builtin.costs import UNREACHABLE_MS
from companion.planning.builtin.fair_entry import entered_fairly
from companion.planning.builtin.loop_entry import ProductPlan, entered_best, least_lap_ms, rank
from companion.planning.builtin.loops import Loops, loops_of
from companion.planning.builtin.masked_actions import KnownActions
from companion.planning.builtin.one_shot_goals import OneShotGoals
from companion.planning.builtin.product import MIN_ONE_SHOT_GOALS, Product
from companion.planning.builtin.restrictions import Restrictions
from companion.planning.builtin.shortest_paths import Edge, ShortestPaths
from companion.planning.domain import Action
from companion.planning.effort import BEFORE_FLIGHT, Effort
from companion.planning.lasso import Lasso, Problem, Solution
from companion.planning.objective import Objective
from companion.slices import spent

ENGINE = "built-in"

MAX_EDGES_WITH_GOALS = 20_000
"""The most edges of a product including one-shot goals for which an exact search is made."""

_NODE_US = 2
_EDGE_US = 0.05

log = logging.getLogger(__name__)


class Search:
    """Plans from any state of one mission.

    Args:
        actions: the actions that every problem contains.
    """

    def __init__(self, actions: Sequence[Action] = ()) -> None:
        self._known = KnownActions(actions)
        self._restrictions = Restrictions()

    def keep(self, actions: Sequence[Action]) -> None:
        """Replaces the actions that every problem contains."""
        self._known.keep(actions)

    def is_solvable(self, problem: Problem, effort: Effort = BEFORE_FLIGHT) -> bool | None:
        """Whether there is a lasso; None if the product has too many states to search."""
        try:
            product = self.product(problem, effort)
            if not product.one_shot_goals:  # then any loop is good enough
                return bool(accepting_components(product))
            return next(_plans(product, Objective.LAP, effort), None) is not None
        except SearchLimit:
            return None

    def solutions(
        self,
        problem: Problem,
        objective: Objective = Objective.LAP,
        effort: Effort = BEFORE_FLIGHT,
    ) -> Iterator[Solution]:
        """Lassos, each better than the one before; none if the task cannot be fulfilled from here.

        The first one comes quickly. The last one is optimal, or has a bound for how far from that
        it is.

        Raises:
            SearchLimit: the product has too many states to search.
        """
        every_part = objective is Objective.BOTTLENECK  # may be met at longest intervals
        product = self._product(problem, effort, with_implied=every_part)
        last: Solution | None = None
        for plan in _plans(product, objective, effort):
            last = _solution(problem, objective, plan)
            yield last
        if last is None or last.is_optimal or every_part or not product.one_shot_goals:
            return
        if product.edges_with_goals <= MAX_EDGES_WITH_GOALS:
            whole = self._product(problem, effort, min_goals=sys.maxsize)
            for plan in _plans(whole, objective, effort):
                if plan.cost_ms <= last.cost_ms:
                    yield _solution(problem, objective, plan)

    def product(
        self,
        problem: Problem,
        effort: Effort = BEFORE_FLIGHT,
        min_goals: int = MIN_ONE_SHOT_GOALS,
    ) -> Product:
        """The product that is searched for a problem's lassos.

        Args:
            problem: the problem to plan for.
            effort: the limits of the search.
            min_goals: from this many one-shot goals on, they are kept out.

        Raises:
            SearchLimit: the product has too many states.
        """
        return self._product(problem, effort, min_goals)

    def _product(
        self,
        problem: Problem,
        effort: Effort,
        min_goals: int = MIN_ONE_SHOT_GOALS,
        with_implied: bool = False,
    ) -> Product:
        product = Product(
            problem, self._known, self._restrictions, effort.product_edges, min_goals, with_implied
        )
        log.debug("product of %d nodes and %d edges", product.nodes, len(product.ends))
        return product


def _solution(problem: Problem, objective: Objective, plan: ProductPlan) -> Solution:
    prefix, loop = (
        tuple(problem.actions[number] for number in part) for part in (plan.prefix, plan.loop)
    )
    lasso = Lasso(prefix, loop)
    log.debug("%s: %d ms, not below %d ms: %s", objective, plan.cost_ms, plan.bound_ms, lasso)
    return Solution(lasso, objective, plan.cost_ms, plan.bound_ms, ENGINE, plan.has_best_prefix)


def accepting_components(product: Product) -> list[NDArray[np.intp]]:
    """The nodes of each strong component with a loop that meets every mark."""
    count, component = connected_components(product.cost_matrix(), connection="strong")
    sources = np.repeat(np.arange(product.nodes), np.diff(product.first))
    inside = component[sources] == component[product.ends]
    has_loop = np.bincount(component[sources[inside]], minlength=count) > 0
    spent(_NODE_US * product.nodes + _EDGE_US * len(product.ends))
    marks = [0] * count
    for node, own in enumerate(component.tolist()):
        marks[own] |= product.marks[node]
    members = np.split(
        np.argsort(component, kind="stable"), np.cumsum(np.bincount(component, minlength=count))
    )
    return [
        members[number] for number in np.flatnonzero(has_loop) if marks[number] == product.all_marks
    ]


def _plans(product: Product, objective: Objective, effort: Effort) -> Iterator[ProductPlan]:
    """Lassos in the product, each better than the one before; none if there is none."""
    components = accepting_components(product)
    if not components or not all(product.one_shot_goals):
        return
    paths = ShortestPaths(product)
    components_loops = [loops_of(product, nodes, paths, effort) for nodes in components]
    best_ms = UNREACHABLE_MS
    for is_second in (False, True):
        for loops in components_loops if is_second else ():
            loops.improve()
        if product.one_shot_goals:
            over_goals = _plan_over_goals(
                product, components_loops, paths, objective, effort, is_second
            )
            if over_goals is None:
                return
            plan, is_final = over_goals
        else:
            cycle = _best_cycle(product, components_loops, paths, objective)
            plan, is_final = cycle.plan, True
            if objective is not Objective.BOTTLENECK:
                plan = entered_best(product, components_loops, paths, objective, plan, effort)
            if objective is Objective.LAP and plan.lap_ms == cycle.plan.lap_ms:
                plan = entered_fairly(product, paths, plan, cycle.loop)
        is_last = is_second or (is_final and all(loops.is_final for loops in components_loops))
        if plan.cost_ms < best_ms or is_last:
            best_ms = plan.cost_ms
            yield plan
        if is_last:
            return


class _Cycle(NamedTuple):
    """A plan whose loop is a cycle of the product, and that cycle."""

    plan: ProductPlan
    loop: list[Edge]


def _best_cycle(
    product: Product, components_loops: list[Loops], paths: ShortestPaths, objective: Objective
) -> _Cycle:
    """The best cycle, entered where it is reached first."""
    best, chosen, entry = (UNREACHABLE_MS, UNREACHABLE_MS, 0), components_loops[0], -1
    for loops in components_loops:
        order = np.lexsort((paths.state_of[loops.nodes], paths.from_start[loops.nodes]))
        nodes = loops.nodes[order]
        for start in range(0, len(nodes), loops.batch_size):
            batch = nodes[start : start + loops.batch_size]
            prefixes = paths.from_start[batch]
            if rank(objective, int(prefixes[0]), loops.best_ms) > best[:2]:
                break
            spent(_NODE_US * len(batch))
            for node, prefix_ms, lap_ms in zip(batch, prefixes, loops.costs(batch), strict=True):
                state = int(paths.state_of[node])
                ranked = (*rank(objective, int(prefix_ms), int(lap_ms)), state)
                if ranked < best:
                    best, chosen, entry = ranked, loops, int(node)
    loop = chosen.loop_from(entry)
    cost_ms = chosen.bottleneck_ms(loop) if objective is Objective.BOTTLENECK else best[0]
    bound_ms = _bound_ms(product, components_loops, paths, objective, cost_ms)
    return _Cycle(_lasso(paths.path_from_start(entry), loop, cost_ms, bound_ms), loop)


def _plan_over_goals(
    product: Product,
    components_loops: list[Loops],
    paths: ShortestPaths,
    objective: Objective,
    effort: Effort,
    is_second: bool,
) -> tuple[ProductPlan, bool] | None:
    """The best cycle, entered after all one-shot goals; None if none can be reached after them.

    Also returns whether a second search could not improve anything.
    """
    is_sum = objective is Objective.SUM
    entries = _entries(components_loops, paths, objective)
    levels = sorted({entry.rank for entry in entries.values()})
    for level in levels[-1:] if is_sum else levels:
        by_state = np.full(product.nodes, UNREACHABLE_MS)
        for state, entry in entries.items():
            if entry.rank <= level:
                by_state[state] = entry.rank if is_sum else 0
        loop_costs = by_state[paths.state_of]
        goals = OneShotGoals(product, paths, loop_costs, effort)
        if is_second:
            goals.improve()
        if goals.cost_ms < UNREACHABLE_MS:
            prefix, last = goals.prefix()
            _, node, loops = entries[int(paths.state_of[last])]
            loop = loops.loop_from(node)
            cost_ms = goals.cost_ms if is_sum else level
            if objective is Objective.BOTTLENECK:
                cost_ms = loops.bottleneck_ms(loop)
            bound_ms = _bound_ms(product, components_loops, paths, objective, cost_ms)
            plan = _lasso(prefix, loop, cost_ms, bound_ms)
            has_best_prefix = goals.is_exact and _meets_no_goal(product, loop)
            return replace(plan, has_best_prefix=has_best_prefix), goals.is_final
    return None


def _meets_no_goal(product: Product, loop: list[Edge]) -> bool:
    """Whether no loop as short as this one meets a goal that its prefix has not met.

    This loop is a rest as short as any action, so other loops of its length are rests as well,
    which meet what was met on arrival; and some goal cannot be met at the start.
    """
    is_rest = len(loop) == 1 and loop[0].cost_ms == product.least_ms
    at_start = set(product.initial)
    return is_rest and not all(at_start & set(nodes) for nodes in product.one_shot_goals)


def _lasso(prefix: list[Edge], loop: list[Edge], cost_ms: int, bound_ms: int) -> ProductPlan:
    return ProductPlan(
        tuple(edge.action for edge in prefix),
        tuple(edge.action for edge in loop),
        sum(edge.cost_ms for edge in prefix),
        sum(edge.cost_ms for edge in loop),
        cost_ms,
        bound_ms,
    )


class _LoopEntry(NamedTuple):
    """A node at which a loop may be entered."""

    rank: int
    node: int
    loops: Loops


def _entries(
    components_loops: list[Loops], paths: ShortestPaths, objective: Objective
) -> dict[int, _LoopEntry]:
    """The best loop to enter at each product state; only the best loops, unless prefixes count."""
    found: dict[int, _LoopEntry] = {}
    for loops in components_loops:
        for node, cost in zip(loops.nodes, loops.costs(loops.nodes), strict=True):
            if objective is Objective.SUM or cost == loops.best_ms:
                ranked, _ = rank(objective, 0, int(cost))
                state = int(paths.state_of[node])
                if state not in found or (ranked, node) < found[state][:2]:
                    found[state] = _LoopEntry(ranked, int(node), loops)
    return found


def _bound_ms(
    product: Product,
    components_loops: list[Loops],
    paths: ShortestPaths,
    objective: Objective,
    cost_ms: int,
) -> int:
    """A lower bound for the cost of all lassos, wherever their loop is entered."""
    if objective is Objective.BOTTLENECK:
        return min(cost_ms, *(loops.bottleneck_bound_ms for loops in components_loops))
    bounds = (
        rank(
            objective,
            int(paths.to_facts[loops.nodes].min()) if objective is Objective.SUM else 0,
            least_lap_ms(product, loops.bound_ms),
        )[0]
        for loops in components_loops
    )
    return min(cost_ms, *bounds)
