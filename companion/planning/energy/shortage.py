"""Explains why the battery does not last for a task for which there would be a plan without it."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from companion.planning.builtin.costs import UNREACHABLE_MS
from companion.planning.builtin.loops import essential_targets
from companion.planning.builtin.search import accepting_components
from companion.planning.charger import UNITS_PER_WH
from companion.planning.effort import Effort
from companion.planning.energy.energy_product import EnergyProduct
from companion.planning.energy.search import BatterySearch
from companion.planning.energy_check import place_of
from companion.planning.lasso import Problem

STRANDED = "no way leads from here to a safe place"
FAR = 100
"""Capacities beyond any real battery: if one does not last, the charge is not the reason."""


def shortages(search: BatterySearch, problem: Problem, effort: Effort) -> tuple[str, ...]:
    """A line for each reason; none if the battery is not the reason.

    Args:
        search: of the mission.
        problem: a problem with energy and without a plan.
        effort: the limits of each search.
    """
    energy = problem.energy
    if energy is None or not search.is_solvable(replace(problem, energy=None), effort):
        return ()
    if is_stranded(problem):
        return (STRANDED,)
    full = replace(problem, energy=replace(energy, level=len(energy.percents) - 1))
    if search.is_solvable(full, effort):
        percent = math.ceil(energy.percents[_least(search, full, energy.level, effort)])
        now = math.floor(energy.percents[max(0, energy.level - energy.borrowed)])
        return (f"the charge, {now} %, is too little: from {percent} % on there is a plan",)
    if (needed := _needed(search, full, effort)) is not None:
        more = needed - (len(energy.percents) - 1)
        return (
            f"the way to its end takes {needed / UNITS_PER_WH:.1f} Wh with the reserve, "
            f"{more / UNITS_PER_WH:.2f} Wh more than a full battery has",
        )
    graph = EnergyProduct(problem, search.plain.product(problem, effort, min_goals=sys.maxsize))
    components = accepting_components(graph.product)
    found = [line for nodes in components for line in _unserved(graph, nodes)]
    return tuple(dict.fromkeys(found)) or ("no charge lasts for the way there",)


def is_stranded(problem: Problem) -> bool:
    """Whether no route leads from the vehicle to a safe place, whatever the charge."""
    energy = problem.energy
    return energy is not None and energy.floor(place_of(problem.facts)) is None


def _least(search: BatterySearch, full: Problem, level: int, effort: Effort) -> int:
    """The lowest level with a plan, between one without a plan and a full battery."""
    assert full.energy is not None
    low, high = max(0, level), full.energy.level
    while high - low > 1:
        middle = (low + high) // 2
        asked = replace(full, energy=replace(full.energy, level=middle))
        low, high = (low, middle) if search.is_solvable(asked, effort) else (middle, high)
    return high


def _needed(search: BatterySearch, full: Problem, effort: Effort) -> int | None:
    """The lowest level, above a full battery's, for which there is a plan without charging.

    None if the loop itself takes more than there is, or if the task has docks, where no battery can
    hold more than a full one.
    """
    if full.energy is None or any(action.charger is not None for action in full.actions):
        return None
    most = replace(full.energy, level=FAR * full.energy.level)
    raised = replace(full, energy=most)
    if not search.is_solvable(raised, effort):
        return None
    return _least(search, raised, full.energy.level, effort)


def _unserved(graph: EnergyProduct, nodes: NDArray[np.intp]) -> Iterator[str]:
    """What a loop in some nodes has to meet although no battery lasts for it."""
    inside = graph.inside(nodes)
    docks = np.flatnonzero(inside & graph.is_charge).tolist()
    if not docks:
        yield "the task goes on for ever, and nothing on its way charges"
        return
    outs, ins = [*map(graph.end, docks)], [*map(graph.start, docks)]
    for group in essential_targets(graph.product, nodes):
        targets = sorted(group)
        paths = graph.paths(inside, [*outs, *targets], is_thrifty=True)
        there, back = paths.table(targets), paths.table(ins)
        flights: list[tuple[int, int, tuple[int, int, int]]] = []
        for i, k, j in np.ndindex(len(docks), len(targets), len(docks)):
            away = len(docks) + k
            if max(there.times_ms[i, k], back.times_ms[away, j]) < UNREACHABLE_MS:
                drain = int(there.drains[i, k] + back.drains[away, j])
                highest, floor = graph.charger(docks[i]).highest, graph.charger(docks[j]).floor
                flights.append((floor + drain - highest, drain, (outs[i], targets[k], ins[j])))
        missing, drain, stops = min(flights, default=(0, 0, (0, 0, 0)))
        if missing > 0:
            names = [graph.places[stop] for stop in stops]
            yield (
                f"{names[1]} cannot be served: {', '.join(names)} takes "
                f"{drain / UNITS_PER_WH:.1f} Wh, {missing / UNITS_PER_WH:.2f} Wh more than a full "
                "battery has above the reserve"
            )
