"""Caches the loops that were found before, and tells whether a product can offer anything better.

The search for a lap takes nearly all the time of a plan, and in flight most plans differ only in
where they begin. So whatever the loops of a component depend on is stored with them: its nodes with
their floors, and its edges with their costs.

1. A component has no shorter loop than an earlier one if each of its nodes and edges was in the
   earlier one, at no higher cost and no higher floor there.
2. If, in addition, the best earlier loop is still possible, edge by edge and level by level, it is
   the best one now.
3. Otherwise the search is made again.

The name of a node is its facts, automaton states and marks; the name of an edge is its ends and
action. Two components for which all of this agrees are the same, whatever their automata mean.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from companion.planning.energy.charging_loops import ChargingLoop, required_before
from companion.planning.energy.energy_product import EnergyProduct
from companion.slices import spent

MOST_KEPT = 8
"""The most components whose loops are kept; the latest ones."""
MOST_EDGES = 20_000
"""Loops of larger components are searched again each time: a comparison would take longer."""
_EDGE_US = 1.5

_Node = tuple[int, tuple[int, ...], int]
_Edge = tuple[int, int, str]
_Cost = tuple[int, int, tuple[object, ...]]
"""Time, energy, and the figures of the charger, if the edge charges."""


@dataclass(frozen=True, slots=True)
class _Ground:
    """What the loops of a component depend on.

    Attributes:
        number_of: by name, a node's number here.
        floors: by this number.
        costs: by edge.
        edges: the edge's name, by its number in the product.
        all_marks: the marks that a loop has to meet.
    """

    number_of: dict[_Node, int]
    floors: list[int]
    costs: dict[_Edge, _Cost]
    edges: dict[int, _Edge]
    all_marks: int


@dataclass(frozen=True, slots=True)
class _Known:
    """The loops of a component, the shortest one first, with names of edges instead of numbers."""

    ground: _Ground
    loops: tuple[tuple[ChargingLoop, tuple[_Edge, ...]], ...]


@dataclass(frozen=True, slots=True)
class LoopsFound:
    """The known loops of a component.

    Attributes:
        is_complete: whether a search would find no others.
    """

    loops: tuple[ChargingLoop, ...]
    is_complete: bool


class KnownLoops:
    """The loops of the components that were searched last."""

    def __init__(self) -> None:
        self._known: list[_Known] = []

    def copied(self) -> KnownLoops:
        """An independent copy."""
        others = KnownLoops()
        others._known = self._known
        return others

    def of(self, graph: EnergyProduct, nodes: NDArray[np.intp]) -> LoopsFound | None:
        """The best loops of a component, as far as known; None if nothing is known.

        Args:
            graph: the product.
            nodes: the nodes of the component.
        """
        if not self._known or (ground := _ground(graph, nodes)) is None:
            return None
        for known in self._known:
            number = _translated(known.ground, ground)
            if number is None:
                continue
            is_same = len(ground.costs) == len(known.ground.costs)
            is_same = is_same and _is_alike(known.ground, ground, number)
            named = {
                (number[a], number[b], name): edge for edge, (a, b, name) in ground.edges.items()
            }
            loops = known.loops if is_same else known.loops[:1]
            found = [_standing(graph, loop, named, known.ground, edges) for loop, edges in loops]
            if all(found):
                kept = tuple(loop for loop in found if loop is not None)
                return LoopsFound(kept, is_same)
        return None

    def keep(
        self, graph: EnergyProduct, nodes: NDArray[np.intp], loops: Sequence[ChargingLoop]
    ) -> None:
        """Stores all loops that a search has found in a component."""
        if not loops or (ground := _ground(graph, nodes)) is None:
            return
        ordered = sorted(loops, key=lambda loop: loop.cost_ms)
        named = tuple((loop, tuple(ground.edges[edge] for edge in loop.edges)) for loop in ordered)
        self._known = [_Known(ground, named), *self._known][:MOST_KEPT]


def _ground(graph: EnergyProduct, nodes: NDArray[np.intp]) -> _Ground | None:
    """What the loops of a component depend on; None if it is too large."""
    product = graph.product
    inside = np.flatnonzero(graph.inside(nodes)).tolist()
    if len(inside) > MOST_EDGES:
        return None
    changing = product.system.changing
    number_of: dict[_Node, int] = {}
    floors, place_of = [], {}
    for node in nodes.tolist():
        key = product.facts(node) & changing, product.automaton_states(node), product.marks[node]
        place_of[node] = number_of[key] = len(number_of)
        floors.append(graph.floors[node])
    costs: dict[_Edge, _Cost] = {}
    edges: dict[int, _Edge] = {}
    for edge in inside:
        spent(_EDGE_US)
        charger = graph.chargers[edge]
        name = place_of[graph.start(edge)], place_of[graph.end(edge)], graph.action(edge).name
        figures = () if charger is None else charger.figures
        drain = 0 if charger is not None else int(graph.drains[edge])
        edges[edge], costs[name] = name, (int(product.costs[edge]), drain, figures)
    return _Ground(number_of, floors, costs, edges, product.all_marks)


def _translated(known: _Ground, ground: _Ground) -> list[int] | None:
    """By node of a component, the node of the other with no less to offer; None if one lacks."""
    if known.all_marks != ground.all_marks:
        return None
    number = [known.number_of.get(name, -1) for name in ground.number_of]
    if -1 in number or any(
        known.floors[at] > floor for at, floor in zip(number, ground.floors, strict=True)
    ):
        return None
    for (a, b, name), (time_ms, drain, figures) in ground.costs.items():
        spent(_EDGE_US / 2)
        before = known.costs.get((number[a], number[b], name))
        if before is None or before[0] > time_ms or before[1] > drain or before[2] != figures:
            return None
    return number


def _is_alike(known: _Ground, ground: _Ground, number: Sequence[int]) -> bool:
    """Whether a component equals an earlier one that has as many edges and offers no less."""
    is_level = all(
        known.floors[at] == floor for at, floor in zip(number, ground.floors, strict=True)
    )
    return is_level and all(
        known.costs[number[a], number[b], name] == cost
        for (a, b, name), cost in ground.costs.items()
    )


def _standing(
    graph: EnergyProduct,
    loop: ChargingLoop,
    numbers: dict[_Edge, int],
    known: _Ground,
    edges: Sequence[_Edge],
) -> ChargingLoop | None:
    """A loop with the present numbers of its edges; None if it is no longer possible."""
    now = [numbers.get(edge) for edge in edges]
    present = [edge for edge in now if edge is not None]
    if len(present) < len(now) or any(
        _differs(graph, *each, known) for each in zip(present, edges, strict=True)
    ):
        return None
    required = required_before(graph, present, loop.levels)
    after = [*required[1:], required[0]]
    lasts = all(
        level is None or level >= needed for level, needed in zip(loop.levels, after, strict=True)
    )
    return replace(loop, edges=tuple(present), required=required) if lasts else None


def _differs(graph: EnergyProduct, number: int, edge: _Edge, known: _Ground) -> bool:
    time_ms, drain, _ = known.costs[edge]
    is_charge = graph.chargers[number] is not None
    now = 0 if is_charge else int(graph.drains[number])
    return (time_ms, drain) != (int(graph.product.costs[number]), now)
