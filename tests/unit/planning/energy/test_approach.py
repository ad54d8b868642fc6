"""The quickest way on the charge that there is, against a search that tries every level."""

from __future__ import annotations

import heapq
from random import Random

import numpy as np
import pytest

from companion.planning.builtin.costs import UNREACHABLE_MS
from companion.planning.charger import Charger
from companion.planning.energy.approach import (
    ChargeLeg,
    EnergyGraph,
    FlightLeg,
    LoopApproach,
    approach,
)


def instance(seed: int) -> tuple[EnergyGraph, list[int], int, dict[int, int]]:
    """A small graph with a few docks, all of one kind."""
    rng = Random(seed)
    size, full = rng.randint(3, 9), rng.randint(12, 40)
    rates = np.sort(np.array([rng.randint(100, 900) for _ in range(full)]))
    times_ms = np.concatenate(([0], np.cumsum(rates))).astype(np.int64)
    reserve = rng.randint(0, 4)
    legs = [
        [
            FlightLeg(end, rng.randint(300, 6000), rng.randint(1, 12))
            for end in range(size)
            if end != node and rng.random() < 0.5
        ]
        for node in range(size)
    ]
    charges: list[list[ChargeLeg]] = [[] for _ in range(size)]
    for _ in range(rng.randint(0, 3)):
        landing, take_off = rng.randint(0, 2), rng.randint(0, 2)
        charger = Charger(reserve + landing, landing, take_off, rng.randint(0, 4000), times_ms)
        charges[rng.randrange(size)].append(ChargeLeg(rng.randrange(size), charger))
    floors = [reserve + rng.randint(0, 5) for _ in range(size)]
    required = {rng.randrange(size): reserve + rng.randint(0, 15) for _ in range(2)}
    return EnergyGraph(legs, charges, floors), [0], rng.randint(reserve, full), required


def exhaustive(graph: EnergyGraph, starts: list[int], level: int, required: dict[int, int]) -> int:
    """The least time over all levels at all docks."""
    pending = [(0, start, level) for start in starts if level >= graph.floors[start]]
    known: set[tuple[int, int]] = set()
    while pending:
        time_ms, node, charge = heapq.heappop(pending)
        if node in required and charge >= required[node]:
            return time_ms
        if (node, charge) in known:
            continue
        known.add((node, charge))
        for leg in graph.legs[node]:
            left = charge - leg.drain
            if left >= graph.floors[leg.end]:
                heapq.heappush(pending, (time_ms + leg.time_ms, leg.end, left))
        for each in graph.charges[node]:
            charger = each.charger
            if charge < charger.floor:
                continue
            for end in range(charge - charger.landing - charger.take_off, charger.highest + 1):
                if end >= graph.floors[each.end]:
                    cost_ms = charger.service_ms(charge, end)
                    heapq.heappush(pending, (time_ms + cost_ms, each.end, end))
    return UNREACHABLE_MS


def flown(graph: EnergyGraph, level: int, found: LoopApproach) -> tuple[int, int]:
    """Time and level at the end of a way, which keeps to all floors."""
    time_ms, node = 0, found.steps[0].node if found.steps else found.end
    for step in found.steps:
        assert step.node == node and level >= graph.floors[node]
        if step.departure is None:
            leg = graph.legs[node][step.number]
            time_ms, level, node = time_ms + leg.time_ms, level - leg.drain, leg.end
        else:
            each = graph.charges[node][step.number]
            assert each.charger.floor <= level and step.departure <= each.charger.highest
            time_ms += each.charger.service_ms(level, step.departure)
            level, node = step.departure, each.end
    assert node == found.end and level >= graph.floors[node]
    return time_ms, level


@pytest.mark.parametrize("seed", range(300))
def test_no_way_is_quicker(seed: int) -> None:
    graph, starts, level, required = instance(seed)
    expected = exhaustive(graph, starts, level, required)
    found = approach(graph, starts, level, required)
    if found is None:
        assert expected >= UNREACHABLE_MS
        return
    assert flown(graph, level, found) == (found.time_ms, found.level)
    assert found.level >= required[found.end]
    assert found.time_ms == expected
