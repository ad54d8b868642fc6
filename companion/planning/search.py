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

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from companion.planning.domain import Action
from companion.planning.lasso import Lasso, Objective, Problem, Solution
from companion.planning.loops import Loops, loops_of
from companion.planning.product import Product, Restrictions
from companion.planning.rounds import FAR
from companion.planning.system import Vocabulary
from companion.planning.ways import Ways

ENGINE = "built-in"


class Search:
    """Plans from any state of one mission.

    Args:
        actions: those that are in every problem.
    """

    def __init__(self, actions: Sequence[Action] = ()) -> None:
        self._vocabulary = Vocabulary(actions)
        self._restrictions = Restrictions()

    def is_solvable(self, problem: Problem) -> bool:
        """Whether there is a lasso.

        Raises:
            SearchLimit: the product has too many states to search.
        """
        return bool(_accepting_components(self._product(problem)))

    def solutions(
        self, problem: Problem, objective: Objective = Objective.LAP
    ) -> Iterator[Solution]:
        """Lassos, each better than the one before; none if the task cannot be done from here.

        The first one comes soon. The last one is optimal, or says how far from it it may be.

        Raises:
            SearchLimit: the product has too many states to search.
        """
        product = self._product(problem)
        components = _accepting_components(product)
        if not components:
            return
        ways = Ways(product)
        offers = [loops_of(product, nodes, ways) for nodes in components]
        best_ms = FAR
        while True:
            cost_ms, loops, entry = _best(offers, ways, objective)
            is_final = all(loops.is_final for loops in offers)
            if cost_ms < best_ms or is_final:
                best_ms = cost_ms
                prefix, suffix = (
                    tuple(problem.actions[stride.action] for stride in part)
                    for part in (ways.arrival(entry), loops.walk(entry))
                )
                bound_ms = _bound_ms(offers, ways, objective, cost_ms)
                yield Solution(Lasso(prefix, suffix), objective, cost_ms, bound_ms, ENGINE)
            if is_final:
                return
            for offer in offers:
                offer.improve()

    def _product(self, problem: Problem) -> Product:
        return Product(problem, self._vocabulary, self._restrictions)


def find_lasso(problem: Problem, objective: Objective = Objective.LAP) -> Lasso | None:
    """The best lasso that is found, or None if the task cannot be done from here.

    Raises:
        SearchLimit: the product has too many states to search.
    """
    lasso = None
    for solution in Search().solutions(problem, objective):
        lasso = solution.lasso
    return lasso


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


def _best(offers: list[Loops], ways: Ways, objective: Objective) -> tuple[int, Loops, int]:
    """The objective, and the loops and the node at which to enter the best one."""
    best, chosen, entry = (FAR, FAR, 0), offers[0], -1
    for loops in offers:
        order = np.lexsort((ways.twins[loops.nodes], ways.arrivals[loops.nodes]))
        nodes = loops.nodes[order]
        wait_ms = loops.wait_ms if objective is Objective.BOTTLENECK else 0
        for start in range(0, len(nodes), loops.at_once):
            some = nodes[start : start + loops.at_once]
            arrivals = ways.arrivals[some]
            if _rank(objective, int(arrivals[0]), loops.best_ms, wait_ms) > best[:2]:
                break
            for node, arrival, cost in zip(some, arrivals, loops.costs(some), strict=True):
                wait_here_ms = wait_ms if cost == loops.best_ms else FAR
                rank = (
                    *_rank(objective, int(arrival), int(cost), wait_here_ms),
                    int(ways.twins[node]),
                )
                if rank < best:
                    best, chosen, entry = rank, loops, int(node)
    return best[0], chosen, entry


def _rank(objective: Objective, prefix_ms: int, lap_ms: int, wait_ms: int) -> tuple[int, int]:
    """The objective of a loop that is entered at some node, then the prefix."""
    match objective:
        case Objective.LAP:
            return lap_ms, prefix_ms
        case Objective.SUM:
            return prefix_ms + lap_ms, prefix_ms
        case Objective.BOTTLENECK:
            return wait_ms, prefix_ms


def _bound_ms(offers: list[Loops], ways: Ways, objective: Objective, cost_ms: int) -> int:
    """What no lasso can be better than."""
    if objective is Objective.BOTTLENECK:
        return min(cost_ms, *(loops.wait_bound_ms for loops in offers))
    if all(loops.bound_ms == loops.best_ms for loops in offers):
        return cost_ms
    nearest = (int(ways.arrivals[loops.nodes].min()) for loops in offers)
    bounds = (
        _rank(objective, prefix_ms, loops.bound_ms, 0)[0]
        for prefix_ms, loops in zip(nearest, offers, strict=True)
    )
    return min(cost_ms, *bounds)
