"""Finds good laps over many stops: one order of all stops, cut optimally into sorties.

Local search improves the order (reverse a part, move a short part, begin elsewhere). Dynamic
programming over positions and docks cuts each order, many orders at once.

Source: Prins, A simple and effective evolutionary algorithm for the vehicle routing problem, 2004.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from companion.planning.builtin.costs import UNREACHABLE_MS, Costs
from companion.planning.charger import Charger
from companion.planning.effort import ADDITION_US
from companion.planning.energy.charging_costs import service_costs
from companion.planning.energy.charging_laps import ChargedSortie
from companion.planning.energy.sorties import PathTable
from companion.slices import spent

Orders = NDArray[np.int64]
"""(orders, places): each row contains every stop once."""
_MAX_SHIFTED = 3
_MOST_ENTRIES = 100_000
"""Number of sorties whose cost is computed at once; limits memory and fits into a slice."""
_PRICES_ADDITIONS, _CUT_US, _CHANGE_US = 4, 20.0, 4.0


class Splits:
    """The best cuts of orders.

    Args:
        paths: the paths between all stops.
        chargers: by stop, its charger.
    """

    def __init__(self, paths: PathTable, chargers: dict[int, Charger]) -> None:
        self._paths, self._docks = paths, list(chargers)
        self._chargers = list(chargers.values())
        size = len(self._docks)
        transfers = np.full((size, size), UNREACHABLE_MS)
        for i, j in np.ndindex(size, size):
            if i != j:
                time_ms, drain = self._path(self._docks[i], self._docks[j])
                transfers[i, j] = self._priced(i, j, np.array(time_ms), np.array(drain))
        self._transfers = transfers

    def costs(self, orders: Orders) -> Costs:
        """(orders,) the cost of the best lap along each order; a lap begins with a charge."""
        places = orders.shape[1]
        batch = max(1, _MOST_ENTRIES // (len(self._docks) ** 2 * places**2))
        parts = [self._reached(orders[i : i + batch]) for i in range(0, len(orders), batch)]
        return np.concatenate([_closed(part) for part in parts])

    def sorties(self, order: Sequence[int]) -> list[ChargedSortie]:
        """The best cut of an order into sorties."""
        reached = self._reached(np.array([order]))[:, 0]  # (start, place, dock)
        prices = self._prices(np.array([order]))[:, :, 0]  # (from, to, first, last)
        start = int(np.array([reached[a, -1, a] for a in range(len(reached))]).argmin())
        here, place, found = start, len(order), []
        while place:
            costs = reached[start, :place] + self._onward(prices, place, here)  # (first, from)
            first, via = np.unravel_index(int(costs.argmin()), costs.shape)
            if (there := self._transferred(reached[start], place, here, costs.min())) is not None:
                found.append(self._sortie(there, here, ()))
                here = there
                continue
            here_before, begin = int(via), int(first)
            found.append(self._sortie(here_before, here, tuple(order[begin:place])))
            here, place = here_before, begin
        while here != start:
            there = int((reached[start, 0] + self._transfers[:, here]).argmin())
            found.append(self._sortie(there, here, ()))
            here = there
        return found[::-1]

    def _onward(self, prices: Costs, place: int, end: int) -> Costs:
        """(first, from) sorties over the places from each first one up to the last."""
        costs: Costs = prices[:, end, :place, place - 1].T
        return costs

    def _transferred(self, reached: Costs, place: int, here: int, least: np.int64) -> int | None:
        """The dock from which a flight without stops leads here, if that is the last step."""
        if reached[place, here] >= least:
            return None
        return int((reached[place] + self._transfers[:, here]).argmin())

    def _sortie(self, i: int, j: int, targets: tuple[int, ...]) -> ChargedSortie:
        stops = [self._docks[i], *targets, self._docks[j]]
        legs = [self._path(a, b) for a, b in pairwise(stops)]
        time_ms, drain = (sum(parts) for parts in zip(*legs, strict=True))
        cost_ms = int(self._priced(i, j, np.array(time_ms), np.array(drain)))
        return ChargedSortie(self._docks[i], self._chargers[j].floor + drain, targets, cost_ms)

    def _path(self, start: int, end: int) -> tuple[int, int]:
        return int(self._paths.times_ms[start, end]), int(self._paths.drains[start, end])

    def _priced(self, i: int, j: int, times_ms: Costs, drains: NDArray[np.int64]) -> Costs:
        return self._departing(i, times_ms, self._chargers[j].floor + drains)

    def _departing(self, i: int, times_ms: Costs, levels: NDArray[np.int64]) -> Costs:
        """The cost to charge at a dock, leave it with some levels, and fly for some times."""
        service_ms = service_costs(self._chargers[i], levels)
        costs: Costs = np.minimum(times_ms + service_ms, UNREACHABLE_MS)
        return costs

    def _prices(self, orders: Orders) -> Costs:
        """(from, to, orders, first, last) the cost of each part of each order, between docks."""
        sums = [
            _along(table, orders) for table in (self._paths.times_ms, self._paths.drains)
        ]  # (orders, first, last)
        size, places = len(self._docks), orders.shape[1]
        found = np.full((size, size, len(orders), places, places), UNREACHABLE_MS)
        forward = np.triu(np.ones((places, places), np.bool_))
        times, drains = self._paths.times_ms, self._paths.drains
        out_ms, out = (
            table[orders[:, :, None], self._docks].transpose(2, 0, 1)[:, :, None, :]
            for table in (times, drains)
        )  # (to, orders, 1, last)
        floors = np.array([charger.floor for charger in self._chargers])[:, None, None, None]
        for i, dock in enumerate(self._docks):
            times_ms = times[dock, orders][:, :, None] + sums[0] + out_ms
            taken = drains[dock, orders][:, :, None] + sums[1] + out
            is_open = forward & (times_ms < UNREACHABLE_MS)
            departures = floors + np.where(is_open, taken, 0)
            costs = self._departing(i, times_ms, departures)
            found[i] = np.where(is_open, costs, UNREACHABLE_MS)
        return found

    def _reached(self, orders: Orders) -> Costs:
        """(start, orders, place, dock): the least cost up to each place, at each dock."""
        size, places = len(self._docks), orders.shape[1]
        spent(_PRICES_ADDITIONS * ADDITION_US * size**2 * orders.size * places)
        prices = self._prices(orders)
        between = self._transfers.copy()
        np.fill_diagonal(between, 0)
        for via in range(size):
            between = np.minimum(between, between[:, via, None] + between[via])
        reached = np.full((size, len(orders), places + 1, size), UNREACHABLE_MS)
        reached[:, :, 0] = between[:, None]
        for place in range(1, places + 1):
            for j in range(size):
                spent(_CUT_US + ADDITION_US * size**2 * len(orders) * place)
                onward = prices[:, j, :, :place, place - 1]  # (from, orders, first)
                before = reached[:, :, :place]  # (start, orders, first, from)
                costs = before + onward.transpose(1, 2, 0)
                reached[:, :, place, j] = costs.reshape(size, len(orders), -1).min(axis=2)
            via = (reached[:, :, place, :, None] + between).min(axis=2)
            reached[:, :, place] = np.minimum(via, UNREACHABLE_MS)
        return reached


def _along(table: NDArray[np.int64], orders: Orders) -> NDArray[np.int64]:
    """(orders, first, last) the sum of the legs from one place of an order to a later one."""
    legs = table[orders[:, :-1], orders[:, 1:]]
    passed = np.concatenate((np.zeros((len(orders), 1), np.int64), legs.cumsum(axis=1)), axis=1)
    sums: NDArray[np.int64] = passed[:, None, :] - passed[:, :, None]
    return sums


def _closed(reached: Costs) -> Costs:
    """(orders,) the best of the starts to which a lap returns."""
    ends = np.array([reached[start, :, -1, start] for start in range(len(reached))])
    least: Costs = ends.min(axis=0)
    return least


def improved(splits: Splits, order: Sequence[int]) -> tuple[list[int], int]:
    """An order that no single change improves, found from a first one, and its cost."""
    best = np.array(order)
    begin = np.array(
        [np.roll(each, turn) for each in (best, best[::-1]) for turn in range(len(best))]
    )
    costs = splits.costs(begin)
    best, best_ms = begin[costs.argmin()], int(costs.min())
    while len(best) > 1:
        changed = []
        for each in _changed(best):
            spent(_CHANGE_US)
            changed.append(each)
        tried = np.array(changed)
        costs = splits.costs(tried)
        if costs.min() >= best_ms:
            break
        best, best_ms = tried[costs.argmin()], int(costs.min())
    return best.tolist(), best_ms


def _changed(order: NDArray[np.int64]) -> Iterator[NDArray[np.int64]]:
    """All orders that a single change can make."""
    size = len(order)
    for turn in range(1, size):
        yield np.roll(order, turn)
    for first in range(size - 1):
        for last in range(first + 2, size + 1):
            yield np.concatenate((order[:first], order[first:last][::-1], order[last:]))
    for length in range(1, min(_MAX_SHIFTED, size - 1) + 1):
        for first in range(size - length + 1):
            part = order[first : first + length]
            rest = np.concatenate((order[:first], order[first + length :]))
            for place in range(len(rest) + 1):
                if place != first:
                    yield np.concatenate((rest[:place], part, rest[place:]))
                    if length > 1:
                        yield np.concatenate((rest[:place], part[::-1], rest[place:]))
