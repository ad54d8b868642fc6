"""Good laps over many stops, against the shortest ones over up to ten."""

from __future__ import annotations

import itertools
from random import Random

import numpy as np
import pytest

from companion.planning.builtin.costs import UNREACHABLE_MS
from companion.planning.charger import Charger
from companion.planning.energy.charging_laps import ChargingLaps
from companion.planning.energy.sorties import PathTable, PathTables
from companion.planning.energy.split import Splits, improved

FIELD = 100
MOST_ABOVE = 1.08


def instance(sites: int, docks: int, seed: int) -> tuple[PathTables, dict[int, Charger]]:
    """Sites and docks on a field, and a battery for about a third of a tour."""
    rng = Random(seed)
    size = sites + docks
    points = np.array([(rng.uniform(0, FIELD), rng.uniform(0, FIELD)) for _ in range(size)])
    distances = np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1))
    times = np.rint(200 * distances).astype(np.int64)
    drains = np.ceil(distances / 2).astype(np.int64)
    np.fill_diagonal(times, 0)
    full = 120
    rates = np.sort(np.array([rng.randint(100, 900) for _ in range(full)]))
    levels = np.concatenate(([0], np.cumsum(rates))).astype(np.int64)
    chargers = {
        dock: Charger(12, 2, rng.randint(0, 3), rng.randint(2000, 30_000), levels)
        for dock in range(sites, size)
    }
    marks = np.array([1 << i for i in range(sites)] + [0] * docks, np.int64)
    table = PathTable(times, drains)
    return PathTables(table, table, marks, frozenset(chargers)), chargers


@pytest.mark.parametrize("seed", range(18))
def test_they_are_no_better_than_the_shortest_and_little_worse(seed: int) -> None:
    sites, docks = 2 + seed % 9, 1 + seed % 2
    paths, chargers = instance(sites, docks, seed)
    best = ChargingLaps(paths, chargers).best()
    splits = Splits(paths.quickest, chargers)
    _order, cost_ms = improved(splits, Random(seed).sample(range(sites), sites))
    if best is None:
        assert cost_ms >= UNREACHABLE_MS
        return
    assert best.bound_ms <= cost_ms <= MOST_ABOVE * best.cost_ms


@pytest.mark.parametrize(
    "seed", [*range(6), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(6, 12))]
)
def test_the_sorties_are_what_is_said_and_each_arrives_at_its_docks_floor(seed: int) -> None:
    sites = 3 + seed
    paths, chargers = instance(sites, 1 + seed % 3, seed)
    splits = Splits(paths.quickest, chargers)
    order, cost_ms = improved(splits, list(range(sites)))
    if cost_ms >= UNREACHABLE_MS:
        return
    sorties = splits.sorties(order)
    assert sum(sortie.cost_ms for sortie in sorties) == cost_ms
    assert [t for sortie in sorties for t in sortie.targets] == order
    for sortie, after in zip(sorties, [*sorties[1:], sorties[0]], strict=True):
        stops = [sortie.dock, *sortie.targets, after.dock]
        legs = list(itertools.pairwise(stops))
        drain = sum(int(paths.quickest.drains[leg]) for leg in legs)
        time_ms = sum(int(paths.quickest.times_ms[leg]) for leg in legs)
        charger, floor = chargers[sortie.dock], chargers[after.dock].floor
        assert sortie.departure - drain == floor and sortie.departure <= charger.highest
        assert sortie.cost_ms == time_ms + charger.service_ms(charger.floor, sortie.departure)


@pytest.mark.parametrize("seed", range(4))
def test_what_many_orders_cost_is_what_each_costs(seed: int) -> None:
    paths, chargers = instance(6, 2, seed)
    splits, rng = Splits(paths.quickest, chargers), Random(seed)
    orders = [rng.sample(range(6), 6) for _ in range(20)]
    together = splits.costs(np.array(orders))
    assert together.tolist() == [int(splits.costs(np.array([each]))[0]) for each in orders]
