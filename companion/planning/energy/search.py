"""The best lasso that the battery lasts for: shortest lap, then shortest prefix.

A loop either rests, which is to land, or charges: a closed chain of sorties between docks
(`rounds.py`; beyond a few marks and docks `split.py`). The way into it takes the charge that there
is, and charges where it needs more (`approach.py`). Each position keeps its floor: the reserve, and
what it takes to land at a safe place.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from companion.errors import SearchLimit
from companion.planning.builtin.costs import UNREACHABLE_MS
from companion.planning.builtin.local_search import LocalSearch
from companion.planning.builtin.loops import essential_targets
from companion.planning.builtin.search import Search, accepting_components
from companion.planning.charger import Charger
from companion.planning.domain import WAIT, Action
from companion.planning.effort import Effort
from companion.planning.energy.approach import Approach, approach
from companion.planning.energy.energy_product import EnergyProduct
from companion.planning.energy.levels import charged
from companion.planning.energy.paths import Paths
from companion.planning.energy.rounds import Round, Rounds
from companion.planning.energy.sorties import Ways
from companion.planning.energy.split import Splits, improved
from companion.planning.lasso import Lasso, Problem, Solution
from companion.planning.objective import Objective

ENGINE = "built-in, energy"
MOST_SETS, MOST_DOCKS = 1 << 11, 4
"""Sets of marks and docks up to which laps are proved to be the shortest."""


@dataclass(frozen=True, slots=True)
class _Loop:
    """A loop.

    Attributes:
        edges: numbers of its edges in their order.
        levels: by place in `edges`, the level after a charge; None for other edges.
        required: by place, what has to be there before the edge.
    """

    edges: tuple[int, ...]
    levels: tuple[int | None, ...]
    required: tuple[int, ...]
    cost_ms: int
    bound_ms: int


def energy_solutions(search: Search, problem: Problem, effort: Effort) -> Iterator[Solution]:
    """The best lasso that the battery lasts for; none if there is none.

    Args:
        search: knows the mission's actions and automata.
        problem: with energy.
        effort: limits of the search.

    Raises:
        SearchLimit: the product has too many states.
    """
    product = search.product(problem, effort, min_goals=sys.maxsize)
    yield from EnergySearch(EnergyProduct(problem, product)).solutions(
        accepting_components(product)
    )


def is_solvable(search: Search, problem: Problem, effort: Effort) -> bool | None:
    """Whether there is a lasso that the battery lasts for; None if a search reaches its limit."""
    try:
        return next(energy_solutions(search, problem, effort), None) is not None
    except SearchLimit:
        return None


class EnergySearch:
    """Looks for lassos in one product."""

    def __init__(self, graph: EnergyProduct) -> None:
        self._graph = graph

    def solutions(self, components: Sequence[NDArray[np.intp]]) -> Iterator[Solution]:
        """The best lasso; none if there is none.

        Args:
            components: the nodes of each strong component with a loop that meets every mark.
        """
        loops = [loop for nodes in components for loop in self._loops(nodes)]
        loops.sort(key=lambda loop: loop.cost_ms)
        best: tuple[Approach, _Loop] | None = None
        for loop in loops:
            if best is not None and loop.cost_ms > best[1].cost_ms:
                break
            way = self._way_into(loop)
            if way is not None and (best is None or way.time_ms < best[0].time_ms):
                best = way, loop
        if best is not None:
            yield self._solution(*best, min(loop.bound_ms for loop in loops))

    # -- loops -------------------------------------------------------------------------------------

    def _loops(self, nodes: NDArray[np.intp]) -> Iterator[_Loop]:
        """The best loops of a component."""
        rests = [rest for node in nodes.tolist() if (rest := self._rest(node)) is not None]
        if rests:  # nothing is shorter
            yield from rests
            return
        inside = self._graph.inside(nodes)
        docks = np.flatnonzero(inside & self._graph.is_charge)
        if len(docks):
            targets_of = essential_targets(self._graph.product, nodes)
            if (loop := self._round(inside, docks.tolist(), targets_of)) is not None:
                yield loop

    def _rest(self, node: int) -> _Loop | None:
        """Rest at a node, if that is a loop that meets all marks."""
        product = self._graph.product
        required = self._graph.energy.rests.get(self._graph.places[node])
        if product.marks[node] != product.all_marks or required is None:
            return None
        for edge in range(product.first[node], product.first[node + 1]):
            if self._graph.action(edge) is WAIT and product.ends[edge] == node:
                cost_ms = int(product.costs[edge])
                return _Loop((edge,), (None,), (required,), cost_ms, cost_ms)
        return None

    def _round(
        self, inside: NDArray[np.bool_], docks: list[int], targets_of: list[frozenset[int]]
    ) -> _Loop | None:
        """The best chain of sorties that meets the marks of some targets."""
        graph = self._graph
        targets = sorted(frozenset[int]().union(*targets_of))
        outs = [*targets, *map(graph.end, docks)]
        ins = [*targets, *map(graph.start, docks)]

        def met(node: int) -> int:
            return sum(1 << mark for mark, group in enumerate(targets_of) if node in group)

        marks = np.array([met(a) | met(b) for a, b in zip(outs, ins, strict=True)], np.int64)
        chargers = {i: graph.charger(dock) for i, dock in enumerate(docks, len(targets))}
        quickest, thriftiest = (graph.paths(inside, outs, thrifty) for thrifty in (False, True))
        ways = Ways(quickest.table(ins), thriftiest.table(ins), marks)
        found = _best_round(ways, chargers, len(targets_of), len(targets))
        if found is None:
            return None
        edges: list[int] = []
        levels: list[int | None] = []
        for sortie, following in pairwise([*found.sorties, found.sorties[0]]):
            paths: Paths = thriftiest if sortie.is_thrifty else quickest
            stops = [sortie.dock, *sortie.targets, following.dock]
            flown = [edge for a, b in pairwise(stops) for edge in paths.path(a, ins[b])]
            edges += [docks[sortie.dock - len(targets)], *flown]
            levels += [sortie.departure, *(None for _ in flown)]
        required = self._required(edges, levels)
        return _Loop(tuple(edges), tuple(levels), required, found.cost_ms, found.bound_ms)

    def _required(self, edges: list[int], levels: list[int | None]) -> tuple[int, ...]:
        """What has to be there before each edge of a loop, whose first one charges."""
        graph = self._graph
        after = max(graph.charger(edges[0]).floor, graph.floors[graph.start(edges[0])])
        found: list[int] = []
        for edge, level in zip(edges[::-1], levels[::-1], strict=True):
            is_flown = level is None
            after = after + int(graph.drains[edge]) if is_flown else graph.charger(edge).floor
            after = max(after, graph.floors[graph.start(edge)])
            found.append(after)
        return tuple(found[::-1])

    # -- the way into a loop -----------------------------------------------------------------------

    def _way_into(self, loop: _Loop) -> Approach | None:
        required: dict[int, int] = {}
        for edge, needed in zip(loop.edges, loop.required, strict=True):
            node = self._graph.start(edge)
            required[node] = min(needed, required.get(node, needed))
        level, starts = self._graph.energy.level, self._graph.product.initial
        return approach(self._graph.graph, starts, level, required)

    def _solution(self, way: Approach, loop: _Loop, bound_ms: int) -> Solution:
        begin = next(
            i
            for i, edge in enumerate(loop.edges)
            if self._graph.start(edge) == way.end and loop.required[i] <= way.level
        )
        edges = loop.edges[begin:] + loop.edges[:begin]
        levels = loop.levels[begin:] + loop.levels[:begin]
        lap = tuple(self._action(edge, to) for edge, to in zip(edges, levels, strict=True))
        lasso = Lasso(tuple(self._prefix(way)), lap)
        return Solution(lasso, Objective.LAP, loop.cost_ms, bound_ms, ENGINE)

    def _prefix(self, way: Approach) -> Iterator[Action]:
        level = self._graph.energy.level
        for step in way.steps:
            edge = self._graph.edge(step.node, step.number, step.departure is not None)
            yield self._action(edge, step.departure, level)
            drained = level - int(self._graph.drains[edge])
            level = drained if step.departure is None else step.departure

    def _action(self, edge: int, departure: int | None, arrival: int | None = None) -> Action:
        """The action of an edge, which charges to a level from that on arrival, or the floor."""
        action = self._graph.action(edge)
        if departure is None:
            return action
        return charged(action, departure, arrival, self._graph.energy.percents)


def _best_round(ways: Ways, chargers: dict[int, Charger], marks: int, targets: int) -> Round | None:
    """The shortest lap, or a good one where there are many marks or docks.

    Args:
        ways: between all stops, targets first.
        chargers: by stop.
        marks: how many there are.
        targets: how many stops are targets.
    """
    if ways.sets <= MOST_SETS and len(chargers) <= MOST_DOCKS:
        return Rounds(ways, chargers).best()
    own = ways.marks[:targets].tolist()
    met = np.array([[bool(bits >> mark & 1) for mark in range(marks)] for bits in own])
    tours = LocalSearch(ways.quickest.times_ms[:targets, :targets].copy(), met)
    tours.improve()
    splits = Splits(ways.quickest, chargers)
    order, cost_ms = improved(splits, tours.cycle())
    if cost_ms >= UNREACHABLE_MS:
        return None
    return Round(tuple(splits.sorties(order)), cost_ms, 0)
