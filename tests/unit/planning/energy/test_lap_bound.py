"""What laps on a battery are not below: never more than the shortest, close with few charges."""

from __future__ import annotations

from random import Random

import numpy as np
import pytest

from companion.planning.charger import Charger
from companion.planning.energy.charging_laps import ChargingLaps
from companion.planning.energy.lap_bound import lap_bound_ms
from companion.planning.energy.sorties import PathTable, PathTables


def field(sites: int, docks: int, full: int, seed: int) -> tuple[PathTables, dict[int, Charger]]:
    """Sites and docks that charge differently, the slower the fuller the battery is."""
    rng = Random(seed)
    size = sites + docks
    points = np.array([(rng.uniform(0, 100), rng.uniform(0, 100)) for _ in range(size)])
    distances = np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1))
    times = np.rint(200 * distances).astype(np.int64)
    table = PathTable(times, np.ceil(distances / 2).astype(np.int64))
    np.fill_diagonal(table.drains, 0)
    chargers = {}
    for dock in range(sites, size):
        rises = np.sort(np.array([rng.uniform(100, 900) for _ in range(full)]))
        levels = np.ceil(np.concatenate(([0.0], np.cumsum(rises)))).astype(np.int64)
        chargers[dock] = Charger(12, 2, rng.randint(0, 3), rng.randint(2000, 30_000), levels)
    marks = np.array([1 << i for i in range(sites)] + [0] * docks, np.int64)
    return PathTables(table, table, marks, frozenset(chargers)), chargers


@pytest.mark.parametrize(
    "seed", [0, 1, *(pytest.param(s, marks=pytest.mark.long) for s in range(2, 60))]
)
def test_no_lap_is_below(seed: int) -> None:
    sites = 3 + seed % 5
    paths, chargers = field(sites, 1 + seed % 2, (90, 150, 400)[seed % 3], seed)
    best = ChargingLaps(paths, chargers).best()
    if best is not None:
        bound_ms = lap_bound_ms(paths, chargers, sites, best.sorties)
        assert 0 < bound_ms <= best.cost_ms


def test_with_one_charge_it_is_close() -> None:
    paths, chargers = field(7, 1, 800, 1)
    best = ChargingLaps(paths, chargers).best()
    assert best is not None and len(best.sorties) == 1
    assert lap_bound_ms(paths, chargers, 7, best.sorties) > 0.9 * best.cost_ms
