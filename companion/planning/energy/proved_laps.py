"""Finds laps over many marks that are proved to be the shortest, before a flight.

1. A good lap (`split.py`) gives the cost that a better one has to be below.
2. The least cost of each sortie (`sortie_table.py`) and the prices of its marks (`mark_prices.py`)
   tell which sorties such a lap may contain.
3. These are few enough (hundreds, or thousands of millions) for a search through their chains
   (`chain_search.py`).

It takes seconds, too long for a flight. With more than about twenty marks there are too many
sorties; then 1-trees limit how far the lap may be from the shortest (`lap_bound.py`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from companion.planning.builtin.costs import UNREACHABLE_MS
from companion.planning.builtin.gtsp import tours
from companion.planning.charger import Charger
from companion.planning.energy.chain_search import ChainSearch
from companion.planning.energy.charging_costs import service_costs
from companion.planning.energy.charging_laps import ChargedSortie, ChargingLap
from companion.planning.energy.lap_bound import lap_bound_ms
from companion.planning.energy.mark_prices import priced
from companion.planning.energy.sortie_table import SortieTable, sortie_table
from companion.planning.energy.sorties import PathTable, PathTables

_TOUR_ADDITIONS = 20_000_000
"""Held and Karp's tables order sorties over up to about fifteen marks exactly."""


def proved(
    paths: PathTables, chargers: Mapping[int, Charger], marks: int, lap: ChargingLap
) -> ChargingLap:
    """A lap with a lower bound for all laps: the shortest lap, or the one that is known.

    Args:
        paths: the paths between all stops.
        chargers: by stop.
        marks: number of marks.
        lap: a known lap.
    """
    table = sortie_table(paths, chargers, marks)
    if table is None:
        bound_ms = lap_bound_ms(paths, chargers, marks, lap.sorties)
        return replace(lap, bound_ms=bound_ms)
    known = [
        int(np.bitwise_or.reduce(paths.marks[list(each.targets)], initial=0))
        for each in lap.sorties
    ]
    worth = priced(table, marks, len(chargers), known, lap.cost_ms)
    found = ChainSearch(worth, marks, lap.cost_ms).best()
    if found.sorties is not None:
        better = _Flown(paths, chargers).lap(worth.table.of(np.array(found.sorties, np.intp)))
        lap = min(lap, better, key=lambda each: each.cost_ms)
    return replace(lap, bound_ms=min(lap.cost_ms, max(found.bound_ms, worth.bound_ms)))


class _Flown:
    """Sorties with their stops in order.

    Args:
        paths: the paths between all stops.
        chargers: by stop.
    """

    def __init__(self, paths: PathTables, chargers: Mapping[int, Charger]) -> None:
        self._paths, self._chargers = paths, chargers

    def lap(self, sorties: SortieTable) -> ChargingLap:
        """The lap that consists of some sorties."""
        docks = list(self._chargers)
        each = zip(
            sorties.origins.tolist(), sorties.ends.tolist(), sorties.sets.tolist(), strict=True
        )
        found = [
            min(self._flown(docks[i], docks[j], marks), key=lambda sortie: sortie.cost_ms)
            for i, j, marks in each
        ]
        return ChargingLap(tuple(found), sum(sortie.cost_ms for sortie in found), 0)

    def _flown(self, origin: int, end: int, marks: int) -> Iterator[ChargedSortie]:
        """A sortie along the quickest paths, and one along those of least energy."""
        charger, floor = self._chargers[origin], self._chargers[end].floor
        tables = (self._paths.quickest, False), (self._paths.least_energy, True)
        for table, is_thrifty in tables:
            targets = self._in_order(table, origin, end, marks)
            legs = [*pairwise((origin, *targets, end))]
            departure = floor + sum(int(table.drains[leg]) for leg in legs)
            time_ms = sum(int(table.times_ms[leg]) for leg in legs)
            cost_ms = time_ms + int(service_costs(charger, np.array(departure)))
            cost_ms = min(cost_ms, UNREACHABLE_MS)
            yield ChargedSortie(origin, departure, targets, cost_ms, is_thrifty)

    def _in_order(self, table: PathTable, origin: int, end: int, marks: int) -> tuple[int, ...]:
        """Stops that meet some marks, in a short order from one dock to another."""
        own = self._paths.marks
        stops = [s for s in range(len(own)) if s not in self._paths.docks and own[s] & marks]
        if not stops:
            return ()
        between = np.full((len(stops) + 1, len(stops) + 1), UNREACHABLE_MS)  # docks come last
        between[:-1, :-1] = table.times_ms[np.ix_(stops, stops)]
        between[-1, :-1], between[:-1, -1] = (
            table.times_ms[origin, stops],
            table.times_ms[stops, end],
        )
        found = tours(between, self._marks_of(stops), _TOUR_ADDITIONS)
        found.improve()
        order = found.cycle()
        begin = order.index(len(stops))
        return tuple(stops[place] for place in order[begin + 1 :] + order[:begin])

    def _marks_of(self, stops: list[int]) -> NDArray[np.bool_]:
        """(stops, marks) of some stops, with marks for the docks, which must also be passed."""
        bits = sorted({int(bit) for bit in self._paths.marks[stops]})
        met = np.zeros((len(stops) + 1, len(bits) + 1), np.bool_)
        met[:-1, :-1] = self._paths.marks[stops, None] == np.array(bits)
        met[-1, -1] = True
        return met
