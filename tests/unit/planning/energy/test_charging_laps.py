"""Laps that last for ever, against a search that tries every level of charge."""

from __future__ import annotations

import heapq
from random import Random

import numpy as np
import pytest

from companion.planning.builtin.costs import UNREACHABLE_MS, Costs
from companion.planning.charger import Charger
from companion.planning.energy.charging_laps import ChargingLap, ChargingLaps, in_order
from companion.planning.energy.sorties import PathTable, PathTables


def instance(seed: int) -> tuple[PathTables, dict[int, Charger], PathTable]:
    """Some sites and docks, with times and drains that need not agree."""
    rng = Random(seed)
    sites, docks, full = rng.randint(1, 5), rng.randint(1, 2), rng.randint(12, 30)
    size = sites + docks
    marks = [1 << i for i in range(sites)] + [0] * docks
    if sites > 2 and rng.random() < 0.3:  # a mark that can be met at two sites
        marks[sites - 1] = 1
        marks = [m if m < 1 << (sites - 1) else 1 for m in marks]
    if rng.random() < 0.3:  # a dock is a site as well
        marks[sites] = 1
    points = [(rng.uniform(0, 10), rng.uniform(0, 10)) for _ in range(size)]
    times = np.zeros((size, size), np.int64)
    drains = np.zeros((size, size), np.int64)
    for i, (x, y) in enumerate(points):
        for j, (u, v) in enumerate(points):
            distance = np.hypot(x - u, y - v) + 0.5
            times[i, j] = 1000 * distance * rng.uniform(1, 1.3)
            drains[i, j] = np.ceil(distance * rng.uniform(0.8, 1.8))
    if rng.random() < 0.2:
        times[rng.randrange(size), rng.randrange(size)] = UNREACHABLE_MS
    rates = np.sort(np.array([rng.randint(100, 900) for _ in range(full)]))
    levels = np.concatenate(([0], np.cumsum(rates))).astype(np.int64)
    reserve = rng.randint(1, 5)
    chargers = {}
    for dock in range(sites, size):
        landing, take_off = rng.randint(0, 2), rng.randint(0, 2)
        chargers[dock] = Charger(reserve + landing, landing, take_off, rng.randint(0, 9000), levels)
    np.fill_diagonal(times, UNREACHABLE_MS)
    paths = closed(times, drains), closed(drains, times)[::-1]
    quickest, least_energy = (PathTable(*table) for table in paths)
    return (
        PathTables(quickest, least_energy, np.array(marks, np.int64)),
        chargers,
        PathTable(times, drains),
    )


def closed(first: Costs, second: Costs) -> tuple[Costs, Costs]:
    """Paths of any number of legs that have the least of one thing, and how much of another."""
    first, second = first.copy(), second.copy()
    second[first >= UNREACHABLE_MS] = UNREACHABLE_MS
    first[second >= UNREACHABLE_MS] = UNREACHABLE_MS
    for via in range(len(first)):
        one = first[:, via, None] + first[via]
        other = second[:, via, None] + second[via]
        is_better = (one < first) | (one == first) & (other < second)
        first, second = np.where(is_better, one, first), np.where(is_better, other, second)
    return first, second


def exhaustive(paths: PathTables, chargers: dict[int, Charger], legs: PathTable) -> int:
    """The shortest lap that ends with no less than it began with, whatever levels it takes."""
    size, everything = len(paths.marks), paths.sets - 1
    best = UNREACHABLE_MS
    for start, charger in chargers.items():
        for level in range(charger.floor, charger.highest + 1):
            pending = [(0, start, 0, level, False)]
            known: dict[tuple[int, int, int], int] = {}
            while pending:
                time_ms, here, met, charge, has_left = heapq.heappop(pending)
                if time_ms >= best:
                    break
                if has_left and here == start and met == everything and charge >= level:
                    best = time_ms
                    break
                if known.get((here, met, charge), UNREACHABLE_MS + 1) <= time_ms and has_left:
                    continue
                known[here, met, charge] = time_ms
                levels = {charge: 0}
                if here in chargers:
                    there = chargers[here]
                    begin = charge - there.landing - there.take_off
                    levels |= {
                        end: there.service_ms(charge, end)
                        for end in range(max(begin, charge + 1), there.highest + 1)
                    }
                for end, cost_ms in levels.items():
                    for after in range(size):
                        path_ms = int(legs.times_ms[here, after])
                        left = end - int(legs.drains[here, after])
                        floor = chargers[after].floor if after in chargers else 0
                        if after == here or path_ms >= UNREACHABLE_MS or left < floor:
                            continue
                        now = met | int(paths.marks[after])
                        heapq.heappush(
                            pending, (time_ms + cost_ms + path_ms, after, now, left, True)
                        )
    return best


def flown(paths: PathTables, chargers: dict[int, Charger], lap: ChargingLap) -> tuple[int, int]:
    """The cost of a lap by its sorties, and the marks it meets; levels are kept to."""
    stops = in_order(list(lap.sorties))
    time_ms, met, charge = 0, 0, chargers[stops[0]].floor
    for number, sortie in enumerate(lap.sorties):
        charger = chargers[sortie.dock]
        assert charger.floor <= charge
        time_ms += charger.service_ms(charge, sortie.departure)
        charge = sortie.departure
        assert charge <= charger.highest
        following = lap.sorties[(number + 1) % len(lap.sorties)].dock
        for here, there in zip(
            (sortie.dock, *sortie.targets), (*sortie.targets, following), strict=True
        ):
            table = paths.least_energy if sortie.is_thrifty else paths.quickest
            time_ms += int(table.times_ms[here, there])
            charge -= int(table.drains[here, there])
            met |= int(paths.marks[there])
    assert charge >= chargers[stops[0]].floor
    return time_ms, met


LARGE = {5, 11, 12}
"""Seeds of which the exhaustive search takes most of the time."""


@pytest.mark.parametrize(
    "seed",
    [
        pytest.param(seed, marks=[pytest.mark.long] if seed >= 10 or seed in LARGE else [])
        for seed in range(60)
    ],
)
def test_no_lap_is_shorter(seed: int) -> None:
    paths, chargers, legs = instance(seed)
    expected = exhaustive(paths, chargers, legs)
    lap = ChargingLaps(paths, chargers).best()
    if lap is None:
        assert expected >= UNREACHABLE_MS
        return
    assert flown(paths, chargers, lap) == (lap.cost_ms, paths.sets - 1)
    assert lap.bound_ms <= expected <= lap.cost_ms
    if lap.bound_ms == lap.cost_ms:
        assert expected == lap.cost_ms
