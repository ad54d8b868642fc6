"""Finds the best lasso of a problem, or a good one with a bound where there are too many.

A mission that loops for ever pays the lap for ever, so by default the shortest lap comes first,
and to it the shortest prefix. The sum of prefix and lap, which a classical planner minimises on
the paper's compilation (Figs. 2-4), takes a lap of 80 on the paper's mission where one of 68
exists.

A loop lies in a strongly connected component of the product that has every mark. In each such
component the marks that every loop meets anyway are dropped; if none is left the best loop is the
shortest cycle (rest, for a task that ends), else the shortest round over hits of the marks
(`rounds.py`), or a good one if there are many (`improve.py`). A prefix leads to any node of a best
loop. Equal costs fall to the order of the actions.

`Search` keeps what does not change between plans: the actions as bits, and the automata under
the constants that it has met. In flight only the facts and the automata's states change.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from companion.planning.builtin.errands import Errands
from companion.planning.builtin.loops import Loops, loops_of
from companion.planning.builtin.product import Product, Restrictions, SearchLimit
from companion.planning.builtin.rounds import FAR
from companion.planning.builtin.system import Vocabulary
from companion.planning.builtin.ways import Stride, Ways
from companion.planning.domain import Action
from companion.planning.effort import ON_THE_GROUND, Effort
from companion.planning.lasso import Lasso, Problem, Solution
from companion.planning.objective import Objective

ENGINE = "built-in"

log = logging.getLogger(__name__)


class Search:
    """Plans from any state of one mission.

    Args:
        actions: those that are in every problem.
    """

    def __init__(self, actions: Sequence[Action] = ()) -> None:
        self._vocabulary = Vocabulary(actions)
        self._restrictions = Restrictions()

    def is_solvable(self, problem: Problem, effort: Effort = ON_THE_GROUND) -> bool | None:
        """Whether there is a lasso; None if the product has too many states to search."""
        try:
            product = self._product(problem, effort)
        except SearchLimit:
            return None
        if not product.errands:  # then any loop will do
            return bool(_accepting_components(product))
        return next(_plans(product, Objective.LAP, effort), None) is not None

    def solutions(
        self,
        problem: Problem,
        objective: Objective = Objective.LAP,
        effort: Effort = ON_THE_GROUND,
    ) -> Iterator[Solution]:
        """Lassos, each better than the one before; none if the task cannot be done from here.

        The first one comes soon. The last one is optimal, or says how far from it it may be.

        Raises:
            SearchLimit: the product has too many states to search.
        """
        for plan in _plans(self._product(problem, effort), objective, effort):
            prefix, suffix = (
                tuple(problem.actions[stride.action] for stride in part)
                for part in (plan.prefix, plan.suffix)
            )
            lasso = Lasso(prefix, suffix)
            log.debug(
                "%s: %d ms, not below %d ms: %s", objective, plan.cost_ms, plan.bound_ms, lasso
            )
            yield Solution(lasso, objective, plan.cost_ms, plan.bound_ms, ENGINE)

    def _product(self, problem: Problem, effort: Effort) -> Product:
        product = Product(problem, self._vocabulary, self._restrictions, effort.edges)
        log.debug("product of %d nodes and %d edges", product.nodes, len(product.targets))
        return product


def _accepting_components(product: Product) -> list[NDArray[np.intp]]:
    """The nodes of each strong component with a loop that meets every mark."""
    count, component = connected_components(product.graph(), connection="strong")
    sources = np.repeat(np.arange(product.nodes), np.diff(product.first))
    inside = component[sources] == component[product.targets]
    has_loop = np.bincount(component[sources[inside]], minlength=count) > 0
    marks = [0] * count
    for node, mine in enumerate(component.tolist()):
        marks[mine] |= product.marks[node]
    members = np.split(
        np.argsort(component, kind="stable"), np.cumsum(np.bincount(component, minlength=count))
    )
    return [
        members[number] for number in np.flatnonzero(has_loop) if marks[number] == product.all_marks
    ]


class _Plan(NamedTuple):
    """A lasso in the product; `is_final` if its prefix will not get better."""

    prefix: list[Stride]
    suffix: list[Stride]
    cost_ms: int
    bound_ms: int
    is_final: bool


def _plans(product: Product, objective: Objective, effort: Effort) -> Iterator[_Plan]:
    """Lassos in the product, each better than the one before; none if there is none."""
    components = _accepting_components(product)
    if not components or not all(product.errands):
        return
    ways = Ways(product)
    offers = [loops_of(product, nodes, ways, effort) for nodes in components]
    best_ms = FAR
    for is_second in (False, True):
        for offer in offers if is_second else ():
            offer.improve()
        plan = (
            _over_errands(product, offers, ways, objective, effort, is_second)
            if product.errands
            else _direct(offers, ways, objective)
        )
        if plan is None:
            return
        is_last = is_second or (plan.is_final and all(loops.is_final for loops in offers))
        if plan.cost_ms < best_ms or is_last:
            best_ms = plan.cost_ms
            yield plan
        if is_last:
            return


def _direct(offers: list[Loops], ways: Ways, objective: Objective) -> _Plan:
    """The best loop, entered where it is reached first."""
    best, chosen, entry = (FAR, FAR, 0), offers[0], -1
    for loops in offers:
        order = np.lexsort((ways.twins[loops.nodes], ways.arrivals[loops.nodes]))
        nodes = loops.nodes[order]
        for start in range(0, len(nodes), loops.at_once):
            some = nodes[start : start + loops.at_once]
            arrivals = ways.arrivals[some]
            if _rank(objective, int(arrivals[0]), loops.best_ms) > best[:2]:
                break
            for node, arrival, cost in zip(some, arrivals, loops.costs(some), strict=True):
                rank = (*_rank(objective, int(arrival), int(cost)), int(ways.twins[node]))
                if rank < best:
                    best, chosen, entry = rank, loops, int(node)
    suffix = chosen.walk(entry)
    cost_ms = chosen.wait_ms(suffix) if objective is Objective.BOTTLENECK else best[0]
    bound_ms = _bound_ms(offers, ways, objective, cost_ms, is_exact=True)
    return _Plan(ways.arrival(entry), suffix, cost_ms, bound_ms, True)


def _over_errands(
    product: Product,
    offers: list[Loops],
    ways: Ways,
    objective: Objective,
    effort: Effort,
    is_second: bool,
) -> _Plan | None:
    """The best loop, entered after all errands; None if none can be reached after them."""
    is_sum = objective is Objective.SUM
    offered = _offered(offers, ways, objective)
    levels = sorted({offer.rank for offer in offered.values()})
    for level in levels[-1:] if is_sum else levels:
        by_twin = np.full(product.nodes, FAR)
        for twin, offer in offered.items():
            if offer.rank <= level:
                by_twin[twin] = offer.rank if is_sum else 0
        loop_costs = by_twin[ways.twins]
        errands = Errands(product, ways, loop_costs, effort)
        if is_second:
            errands.improve()
        if errands.cost_ms < FAR:
            prefix, entry = errands.walk()
            _, node, loops = offered[int(ways.twins[entry])]
            suffix = loops.walk(node)
            cost_ms = errands.cost_ms if is_sum else level
            if objective is Objective.BOTTLENECK:
                cost_ms = loops.wait_ms(suffix)
            bound_ms = _bound_ms(offers, ways, objective, cost_ms, errands.is_exact)
            return _Plan(prefix, suffix, cost_ms, bound_ms, errands.is_final)
    return None


class _Offer(NamedTuple):
    """A loop that may be entered at a node."""

    rank: int
    node: int
    loops: Loops


def _offered(offers: list[Loops], ways: Ways, objective: Objective) -> dict[int, _Offer]:
    """The best loop to enter at each twin; unless prefixes count, only loops that are best."""
    found: dict[int, _Offer] = {}
    for loops in offers:
        for node, cost in zip(loops.nodes, loops.costs(loops.nodes), strict=True):
            if objective is Objective.SUM or cost == loops.best_ms:
                rank, _ = _rank(objective, 0, int(cost))
                twin = int(ways.twins[node])
                if twin not in found or (rank, node) < found[twin][:2]:
                    found[twin] = _Offer(rank, int(node), loops)
    return found


def _rank(objective: Objective, prefix_ms: int, lap_ms: int) -> tuple[int, int]:
    """The smaller the better: what is minimised, then the prefix."""
    cost_ms = prefix_ms + lap_ms if objective is Objective.SUM else lap_ms
    return cost_ms, prefix_ms


def _bound_ms(
    offers: list[Loops], ways: Ways, objective: Objective, cost_ms: int, is_exact: bool
) -> int:
    """What no lasso can be better than; `is_exact` if the prefix is the best one."""
    if objective is Objective.BOTTLENECK:
        return min(cost_ms, *(loops.wait_bound_ms for loops in offers))
    if objective is Objective.SUM and is_exact and all(loops.is_exact for loops in offers):
        return cost_ms
    bounds = (
        _rank(objective, int(ways.arrivals[loops.nodes].min()), loops.bound_ms)[0]
        for loops in offers
    )
    return min(cost_ms, *bounds)
