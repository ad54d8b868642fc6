"""The best loops of a component on a battery: closed chains of sorties between docks.

A group of docks that reach each other on full charges has one best loop (`charging_laps.py`; with
more than a few marks and docks, `split.py`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from companion.errors import SearchLimit
from companion.planning.builtin.costs import UNREACHABLE_MS
from companion.planning.builtin.local_search import LocalSearch
from companion.planning.builtin.loops import essential_targets
from companion.planning.charger import Charger
from companion.planning.energy.charging_laps import ChargingLap, ChargingLaps
from companion.planning.energy.energy_product import EnergyProduct
from companion.planning.energy.paths import Paths
from companion.planning.energy.proved_laps import proved
from companion.planning.energy.sorties import PathTables, joined
from companion.planning.energy.split import Splits, improved

MOST_MARKS = 62
"""Limit because marks are bits of a 64-bit number."""
MOST_ADDITIONS = 12_000_000
"""Up to this many additions for all chains of sorties, laps are proved to be the shortest."""
FEW_TARGETS = 3
"""With at most this many targets, every order is tried anyway."""


@dataclass(frozen=True, slots=True)
class ChargingLoop:
    """A loop that contains charges.

    Attributes:
        edges: numbers of its edges in their order; the first one charges.
        levels: by place in `edges`, the level after a charge; None for other edges.
        required: by place in `edges`, the level required before the edge.
        bound_ms: a lower bound for the loops of the component; 0 if nothing is known.
    """

    edges: tuple[int, ...]
    levels: tuple[int | None, ...]
    required: tuple[int, ...]
    cost_ms: int
    bound_ms: int


def best_loops(
    graph: EnergyProduct, nodes: NDArray[np.intp], is_proved: bool = False
) -> Iterator[ChargingLoop]:
    """The best loop for each group of docks of a component that reach each other.

    Args:
        graph: the product.
        nodes: those of a strong component with a loop that meets every mark.
        is_proved: whether there is time to search for the shortest lap, or for a bound.

    Raises:
        SearchLimit: it has too many marks.
    """
    inside = graph.inside(nodes)
    docks = [
        edge
        for edge in np.flatnonzero(inside & graph.is_charge).tolist()
        if graph.charger(edge).is_of_use
    ]
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
    quickest, least_energy = (graph.paths(inside, outs, thrifty) for thrifty in (False, True))
    stops = frozenset(range(len(targets), len(outs)))
    paths = PathTables(quickest.table(ins), least_energy.table(ins), marks, stops)
    chargers = {i: graph.charger(dock) for i, dock in enumerate(docks, len(targets))}
    for group in joined(paths.least_energy, chargers):
        found = _best_round(paths, group, len(targets_of), is_proved)
        if found is None:
            continue
        edges: list[int] = []
        levels: list[int | None] = []
        for sortie, following in pairwise([*found.sorties, found.sorties[0]]):
            flown_by: Paths = least_energy if sortie.is_thrifty else quickest
            passed = [sortie.dock, *sortie.targets, following.dock]
            flown = [edge for a, b in pairwise(passed) for edge in flown_by.path(a, ins[b])]
            edges += [docks[sortie.dock - len(targets)], *flown]
            levels += [sortie.departure, *(None for _ in flown)]
        required = required_before(graph, edges, levels)
        yield ChargingLoop(tuple(edges), tuple(levels), required, found.cost_ms, found.bound_ms)


def required_before(
    graph: EnergyProduct, edges: Sequence[int], levels: Sequence[int | None]
) -> tuple[int, ...]:
    """The level required before each edge of a loop whose first edge charges."""
    after = max(graph.charger(edges[0]).floor, graph.floors[graph.start(edges[0])])
    found: list[int] = []
    for edge, level in zip(edges[::-1], levels[::-1], strict=True):
        is_flown = level is None
        after = after + int(graph.drains[edge]) if is_flown else graph.charger(edge).floor
        after = max(after, graph.floors[graph.start(edge)])
        found.append(after)
    return tuple(found[::-1])


def _best_round(
    paths: PathTables, chargers: dict[int, Charger], marks: int, is_proved: bool
) -> ChargingLap | None:
    """The shortest lap, or a good one if there are many marks or docks.

    Args:
        paths: the paths between all stops.
        chargers: by stop, of docks that reach each other.
        marks: number of marks.
        is_proved: whether there is time to search for the shortest lap, or for a bound.
    """
    served = paths.served(chargers)
    own = paths.marks[served]
    if np.bitwise_or.reduce(own, initial=0) != (1 << marks) - 1:
        return None
    if 3**marks * len(chargers) ** 3 <= MOST_ADDITIONS:
        return ChargingLaps(paths, chargers).best(is_proved)
    targets = [stop for stop in served if stop not in paths.docks]
    met = np.array([[bool(paths.marks[t] >> mark & 1) for mark in range(marks)] for t in targets])
    for table, is_thrifty in (paths.quickest, False), (paths.least_energy, True):
        tours = LocalSearch(table.times_ms[np.ix_(targets, targets)], met)
        if len(targets) > FEW_TARGETS and (table.times_ms < UNREACHABLE_MS).all():
            tours.improve()
        splits = Splits(table, chargers)
        order, cost_ms = improved(splits, [targets[place] for place in tours.cycle()])
        if cost_ms < UNREACHABLE_MS:
            sorties = [replace(each, is_thrifty=is_thrifty) for each in splits.sorties(order)]
            lap = ChargingLap(tuple(sorties), cost_ms, 0)
            return proved(paths, chargers, marks, lap) if is_proved else lap
    return None
