"""The best lasso that the battery lasts for: shortest lap, then shortest prefix.

A loop either rests, which is to land, or charges: a closed chain of sorties between docks that
reach each other on full charges (`charging_laps.py`; beyond a few marks and docks `split.py`).
The way into it takes the charge that there is, and charges where it needs more (`approach.py`).
Each position keeps its floor: the reserve, and what it takes to land at a safe place.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from companion.errors import SearchLimit
from companion.planning.builtin.costs import UNREACHABLE_MS
from companion.planning.builtin.local_search import LocalSearch
from companion.planning.builtin.loops import essential_targets
from companion.planning.builtin.search import Search, accepting_components
from companion.planning.charger import Charger
from companion.planning.domain import WAIT, Action
from companion.planning.effort import Effort
from companion.planning.energy.approach import LoopApproach, approach
from companion.planning.energy.charged_actions import charged
from companion.planning.energy.charging_laps import ChargingLap, ChargingLaps
from companion.planning.energy.energy_product import EnergyProduct
from companion.planning.energy.paths import Paths
from companion.planning.energy.sorties import WayTables, joined
from companion.planning.energy.split import Splits, improved
from companion.planning.lasso import Lasso, Problem, Solution
from companion.planning.objective import Objective

ENGINE = "built-in, energy"
MOST_MARKS = 62
"""They are bits of a number."""
MOST_ADDITIONS = 12_000_000
"""With so many for all chains of sorties, laps are proved to be the shortest."""
FEW_TARGETS = 3
"""Of so few every order is tried anyway."""


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
        if (rest := self._resting()) is not None:
            yield rest  # nothing is shorter
            return
        loops = [loop for nodes in components for loop in self._rounds(nodes)]
        loops.sort(key=lambda loop: loop.cost_ms)
        best: tuple[LoopApproach, _Loop] | None = None
        for loop in loops:
            if best is not None and loop.cost_ms > best[1].cost_ms:
                break
            way = self._way_into(loop)
            if way is not None and (best is None or way.time_ms < best[0].time_ms):
                best = way, loop
        if best is not None:
            bound_ms = min(loop.bound_ms for loop in loops)
            yield self._solution(*best, bound_ms // self._graph.product.max_laps)

    # -- rest --------------------------------------------------------------------------------------

    def _resting(self) -> Solution | None:
        """The quickest way to where the vehicle may rest for ever."""
        way = self._approach(self._rests())
        if way is None:
            return None
        lasso = Lasso(tuple(self._prefix(way)), (WAIT,))
        return Solution(lasso, Objective.LAP, WAIT.cost_ms, WAIT.cost_ms, ENGINE)

    def _rests(self) -> dict[int, int]:
        """By node from which rest for ever is accepted: what has to be there to land."""
        graph, product = self._graph, self._graph.product
        waits = np.flatnonzero([action is WAIT for action in graph.actions])
        before, after = graph.sources[waits], product.ends[waits]
        shape = product.nodes, product.nodes
        resting = csr_array((np.ones(len(waits)), (before, after)), shape=shape)
        count, component = connected_components(resting, connection="strong")
        marks, is_cycle = [0] * count, np.zeros(count, np.bool_)
        is_cycle[component[before[component[before] == component[after]]]] = True
        for node, own in enumerate(component.tolist()):
            marks[own] |= product.marks[node]
        accepted = np.array([met == product.all_marks for met in marks], np.bool_) & is_cycle
        pending = np.flatnonzero(accepted[component]).tolist()
        into: dict[int, list[int]] = {}
        for a, b in zip(before.tolist(), after.tolist(), strict=True):
            into.setdefault(b, []).append(a)
        found: dict[int, int] = {}
        while pending:
            node = pending.pop()
            required = graph.energy.rests.get(graph.places[node])
            if node not in found and required is not None:
                found[node] = required
                pending += into.get(node, [])  # a step of rest more is the same word
        return found

    # -- loops -------------------------------------------------------------------------------------

    def _rounds(self, nodes: NDArray[np.intp]) -> Iterator[_Loop]:
        """The best loops of a component: for docks that reach each other, the best one."""
        graph = self._graph
        inside = graph.inside(nodes)
        docks = np.flatnonzero(inside & graph.is_charge).tolist()
        if not docks:
            return
        targets_of = essential_targets(graph.product, nodes)
        if len(targets_of) > MOST_MARKS:
            raise SearchLimit(f"{MOST_MARKS} marks of a loop on a battery")
        targets = sorted(frozenset[int]().union(*targets_of))
        outs = [*targets, *map(graph.end, docks)]
        ins = [*targets, *map(graph.start, docks)]

        def met(node: int) -> int:
            return sum(1 << mark for mark, group in enumerate(targets_of) if node in group)

        marks = np.array([met(a) | met(b) for a, b in zip(outs, ins, strict=True)], np.int64)
        quickest, thriftiest = (graph.paths(inside, outs, thrifty) for thrifty in (False, True))
        stops = frozenset(range(len(targets), len(outs)))
        ways = WayTables(quickest.table(ins), thriftiest.table(ins), marks, stops)
        chargers = {i: graph.charger(dock) for i, dock in enumerate(docks, len(targets))}
        for group in joined(ways.thriftiest, chargers):
            found = _best_round(ways, group, len(targets_of))
            if found is None:
                continue
            edges: list[int] = []
            levels: list[int | None] = []
            for sortie, following in pairwise([*found.sorties, found.sorties[0]]):
                paths: Paths = thriftiest if sortie.is_thrifty else quickest
                passed = [sortie.dock, *sortie.targets, following.dock]
                flown = [edge for a, b in pairwise(passed) for edge in paths.path(a, ins[b])]
                edges += [docks[sortie.dock - len(targets)], *flown]
                levels += [sortie.departure, *(None for _ in flown)]
            required = self._required(edges, levels)
            yield _Loop(tuple(edges), tuple(levels), required, found.cost_ms, found.bound_ms)

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

    def _way_into(self, loop: _Loop) -> LoopApproach | None:
        required: dict[int, int] = {}
        for edge, needed in zip(loop.edges, loop.required, strict=True):
            node = self._graph.start(edge)
            required[node] = min(needed, required.get(node, needed))
        return self._approach(required)

    def _approach(self, required: dict[int, int]) -> LoopApproach | None:
        level, starts = self._graph.energy.level, self._graph.product.initial
        return approach(self._graph.graph, starts, level, required) if required else None

    def _solution(self, way: LoopApproach, loop: _Loop, bound_ms: int) -> Solution:
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

    def _prefix(self, way: LoopApproach) -> Iterator[Action]:
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


def _best_round(ways: WayTables, chargers: dict[int, Charger], marks: int) -> ChargingLap | None:
    """The shortest lap, or a good one where there are many marks or docks.

    Args:
        ways: between all stops.
        chargers: by stop, of docks that reach each other.
        marks: how many there are.
    """
    served = ways.served(chargers)
    own = ways.marks[served]
    if np.bitwise_or.reduce(own, initial=0) != (1 << marks) - 1:
        return None
    if 3**marks * len(chargers) ** 3 <= MOST_ADDITIONS:
        return ChargingLaps(ways, chargers).best()
    targets = [stop for stop in served if stop not in ways.docks]
    met = np.array([[bool(ways.marks[t] >> mark & 1) for mark in range(marks)] for t in targets])
    for table, is_thrifty in (ways.quickest, False), (ways.thriftiest, True):
        tours = LocalSearch(table.times_ms[np.ix_(targets, targets)], met)
        if len(targets) > FEW_TARGETS and (table.times_ms < UNREACHABLE_MS).all():
            tours.improve()
        splits = Splits(table, chargers)
        order, cost_ms = improved(splits, [targets[place] for place in tours.cycle()])
        if cost_ms < UNREACHABLE_MS:
            sorties = [replace(each, is_thrifty=is_thrifty) for each in splits.sorties(order)]
            return ChargingLap(tuple(sorties), cost_ms, 0)
    return None
