"""Laps that are proved before a flight, against the exact tables over up to eight sites."""

from __future__ import annotations

from dataclasses import replace
from random import Random

import numpy as np
import pytest

from companion.planning.builtin.costs import UNREACHABLE_MS
from companion.planning.charger import Charger
from companion.planning.energy import chain_search
from companion.planning.energy import sortie_table as tables
from companion.planning.energy.charging_laps import ChargingLap, ChargingLaps
from companion.planning.energy.lap_bound import lap_bound_ms
from companion.planning.energy.mark_prices import MarkPrices, priced
from companion.planning.energy.proved_laps import proved
from companion.planning.energy.sortie_table import SortieTable, sortie_table
from companion.planning.energy.sorties import PathTable, PathTables, Sorties
from companion.planning.energy.split import Splits

ALL = 200


def field(sites: int, docks: int, seed: int) -> tuple[PathTables, dict[int, Charger]]:
    """Sites and docks, and a battery for a fifth of a tour to all of one.

    Wind makes paths back cost other times, or what takes the least time is not the thriftiest. Some
    docks charge alike.
    """
    rng = Random(seed)
    size, full = sites + docks, rng.choice((80, 120, 200, 500))
    points = np.array([(rng.uniform(0, 100), rng.uniform(0, 100)) for _ in range(size)])
    offsets = points[:, None] - points[None]
    distances = np.hypot(offsets[..., 0], offsets[..., 1])
    times = np.rint(200 * distances * (1 + rng.choice((0, 0.2)) * np.sign(offsets[..., 0])))
    drains = np.ceil(distances / 2)
    is_odd = rng.random() < 0.3
    quick, thrifty = drains + is_odd * (3 - 3 * np.eye(size)), times * (1 + 0.1 * is_odd)
    is_alike, chargers = rng.random() < 0.7, {}
    rises = np.sort(np.array([rng.uniform(100, 900) for _ in range(full)]))
    for dock in range(sites, size):
        if not is_alike:
            rises = np.sort(np.array([rng.uniform(100, 900) for _ in range(full)]))
        levels = np.ceil(np.concatenate(([0.0], np.cumsum(rises)))).astype(np.int64)
        floor, take_off = rng.randint(8, 14), rng.randint(0, 3)
        chargers[dock] = Charger(floor, 2, take_off, rng.randint(2000, 30_000), levels)
    marks = np.array([1 << i for i in range(sites)] + [0] * docks, np.int64)
    quickest = PathTable(_shortest(times), quick.astype(np.int64))
    least_energy = PathTable(thrifty.astype(np.int64), _shortest(drains))
    return PathTables(quickest, least_energy, marks, frozenset(chargers)), chargers


def _shortest(table: np.ndarray) -> np.ndarray:
    """Paths are shortest paths."""
    table = table.astype(np.int64)
    for via in range(len(table)):
        table = np.minimum(table, table[:, via, None] + table[via])
    return table


def known_lap(paths: PathTables, chargers: dict[int, Charger], seed: int) -> ChargingLap | None:
    """A bad lap."""
    sites = int((paths.marks > 0).sum())
    splits, order = Splits(paths.quickest, chargers), Random(seed).sample(range(sites), sites)
    cost_ms = int(splits.costs(np.array([order]))[0])
    if cost_ms >= UNREACHABLE_MS:
        return None
    return ChargingLap(tuple(splits.sorties(order)), cost_ms, 0)


def seeds(some: int) -> list[object]:
    return [*range(some), *(pytest.param(s, marks=pytest.mark.long) for s in range(some, ALL))]


@pytest.mark.parametrize("seed", seeds(8))
def test_a_bound_is_never_above_the_shortest_lap(seed: int) -> None:
    sites = 2 + seed % 7
    paths, chargers = field(sites, 1 + seed % 3, seed)
    lap, best = known_lap(paths, chargers, seed), ChargingLaps(paths, chargers).best()
    if lap is None or best is None:
        return
    found = proved(paths, chargers, sites, lap)
    assert best.bound_ms <= found.cost_ms <= lap.cost_ms
    assert 0 < found.bound_ms <= best.cost_ms
    if best.bound_ms == best.cost_ms:
        assert found.bound_ms == found.cost_ms == best.cost_ms


@pytest.mark.parametrize("seed", seeds(4))
def test_it_holds_for_any_prices(seed: int) -> None:
    sites, docks = 3 + seed % 5, 1 + seed % 3
    paths, chargers = field(sites, docks, seed)
    best, table = ChargingLaps(paths, chargers).best(), sortie_table(paths, chargers, sites)
    if best is None:
        return
    assert table is not None
    chance = np.random.default_rng(seed)
    for _ in range(20):
        prices = MarkPrices(
            chance.integers(0, 2 * best.cost_ms // sites, sites),
            chance.integers(-20_000, 20_000, docks),
        )
        least = min(0, int(prices.reduced(table).min()))
        most = best.cost_ms // int(table.costs_ms.min())
        assert int(prices.marks.sum()) + most * least <= best.cost_ms


@pytest.mark.parametrize("seed", range(6))
def test_the_table_has_what_sorties_cost_at_least(seed: int) -> None:
    sites, docks = 3 + seed % 4, 1 + seed % 2
    paths, chargers = field(sites, docks, seed)
    sorties, table = Sorties(paths, list(chargers)), sortie_table(paths, chargers, sites)
    assert table is not None
    for i, j in np.ndindex(docks, docks):
        own = table.of((table.origins == i) & (table.ends == j))
        times = sorties.between(i, j)
        origin, floor = list(chargers.values())[i], list(chargers.values())[j].floor
        lasts = times.thriftiest_drain + floor <= origin.highest
        assert sorted(own.sets.tolist()) == np.flatnonzero(lasts).tolist()
        is_alike = len({c.times_ms.tobytes() for c in chargers.values()}) == 1
        for met, cost_ms in zip(own.sets.tolist(), own.costs_ms.tolist(), strict=True):
            if is_alike and (met or i != j):
                departure = floor + int(times.thriftiest_drain[met])
                charge_ms = origin.service_ms(origin.floor, departure)
                assert cost_ms == times.quickest_ms[met] + charge_ms


def test_with_too_many_sets_one_trees_say_how_good_a_lap_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    paths, chargers = field(6, 1, 3)
    lap = known_lap(paths, chargers, 3)
    assert lap is not None
    monkeypatch.setattr(tables, "MOST_SETS", 10)
    found = proved(paths, chargers, 6, lap)
    assert found == replace(lap, bound_ms=lap_bound_ms(paths, chargers, 6, lap.sorties))


@pytest.mark.parametrize("seed", range(4))
def test_no_sortie_is_too_cheap_at_the_end(seed: int) -> None:
    paths, chargers = field(7, 2, seed)
    lap, table = known_lap(paths, chargers, seed), sortie_table(paths, chargers, 7)
    if lap is None:
        return
    assert isinstance(table, SortieTable)
    found = priced(table, 7, 2, [], lap.cost_ms)
    assert found.reduced.min() >= 0 and found.bound_ms == found.base_ms


@pytest.mark.parametrize("seed", range(4))
def test_a_search_that_is_given_up_has_a_bound_as_well(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(chain_search, "MOST_SORTIES", 20_000)
    paths, chargers = field(8, 2, seed)
    lap, best = known_lap(paths, chargers, seed), ChargingLaps(paths, chargers).best()
    if lap is None or best is None:
        return
    found = proved(paths, chargers, 8, lap)
    assert best.bound_ms <= found.cost_ms and 0 < found.bound_ms <= best.cost_ms
