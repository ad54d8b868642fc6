"""Prices of marks: no lap costs less than the prices of all marks together.

Each mark has a nonnegative price, and each dock a price of any sign. The reduced cost of a sortie
is its cost, minus the prices of the marks that it meets and of the dock where it begins, plus the
price of the dock where it ends. Around a lap the prices of docks cancel out.

1. If no reduced cost is negative, no lap costs less than the prices of all marks.
2. If the least reduced cost is negative, it is added to this bound once for each sortie of a lap.

This holds for any prices, and is computed in whole milliseconds. So the bound does not depend on
how the prices were found. They are found by column generation: a linear programme over few sorties
gives prices for the marks, and sorties that are too cheap for these prices are added, until there
are none.

Source: Desrosiers and Lübbecke, A primer in column generation, 2005; the bound is Lasdon's, 1970.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from companion.planning.energy.sortie_table import Numbers, SortieTable
from companion.slices import spent

MOST_ROUNDS = 400
_ADDED = 100
"""The most sorties that a pass adds for each pair of docks."""
_KEPT = 0.7
"""Sorties that are in no cheaper lap are removed if at most this share of all is kept."""
_ROUNDED_MS = 2
"""How much the prices are reduced below those of the programme, so that rounding cannot make them
too high."""
_NEAR, _NEAR_ROUNDS = 100_000, 3
"""Too cheap sorties are first sought among this many of least reduced cost, in this many passes,
before all are examined again."""
_PRICES_US, _SORTIE_US = 5_000.0, 0.02


@dataclass(frozen=True, eq=False)
class MarkPrices:
    """Prices in whole ms.

    Attributes:
        marks: (marks,), none is negative.
        docks: (docks,), of any sign.
    """

    marks: Numbers
    docks: Numbers

    def reduced(self, table: SortieTable) -> Numbers:
        """(sorties,) the reduced costs."""
        worth = np.zeros(1, np.int64)
        for price in self.marks:
            worth = np.concatenate((worth, worth + price))
        spent(_SORTIE_US * len(table.sets))
        docks = self.docks[table.ends] - self.docks[table.origins]
        reduced: Numbers = table.costs_ms - worth[table.sets] + docks
        return reduced


@dataclass(frozen=True, eq=False)
class PricedSorties:
    """The sorties of all laps that cost less than a known one.

    Attributes:
        base_ms: the prices of all marks together.
        reduced: (sorties,) reduced costs with these prices.
        bound_ms: a lower bound for the cost of all laps.
    """

    table: SortieTable
    base_ms: int
    reduced: Numbers
    bound_ms: int


def priced(
    table: SortieTable, marks: int, docks: int, known: Sequence[int], known_ms: int
) -> PricedSorties:
    """Prices that make the bound as high as possible.

    Args:
        table: all sorties.
        marks: number of marks.
        docks: number of docks.
        known: sets of marks of the sorties of a known lap.
        known_ms: the cost of that lap.
    """
    most = max(1, known_ms // max(1, int(table.costs_ms.min())))  # the most sorties of a lap
    begin = np.isin(table.sets, [0, *known, *(1 << mark for mark in range(marks))])
    programme = _Programme(table.of(begin), marks, docks, known_ms)
    best = PricedSorties(table, 0, table.costs_ms, 0)
    for _ in range(MOST_ROUNDS):
        prices = programme.prices()
        reduced, base_ms = prices.reduced(table), int(prices.marks.sum())
        least = min(0, int(reduced.min(initial=0)))
        if base_ms + most * least >= best.bound_ms:
            best = PricedSorties(table, base_ms, reduced, base_ms + most * least)
        if not least:
            break
        near = np.argpartition(reduced, _NEAR)[:_NEAR] if len(reduced) > _NEAR else slice(None)
        programme.settle(table.of(near))
        is_of_use = reduced <= known_ms - base_ms - (most - 1) * least
        if is_of_use.mean() < _KEPT:
            table = table.of(is_of_use)
            best = PricedSorties(table, best.base_ms, best.reduced[is_of_use], best.bound_ms)
    return best


def _cheapest(table: SortieTable, reduced: Numbers) -> NDArray[np.intp]:
    """The too cheap sorties of the least reduced cost between each pair of docks."""
    negative = np.flatnonzero(reduced < 0)
    pairs = table.origins[negative].astype(np.int64) << 8 | table.ends[negative]
    found = [negative[:0]]
    for pair in np.unique(pairs).tolist():
        own = negative[pairs == pair]
        if len(own) > _ADDED:
            own = own[np.argpartition(reduced[own], _ADDED)[:_ADDED]]
        found.append(own)
    return np.concatenate(found)


class _Programme:
    """The linear programme over some sorties; a mark may be bought at the price of a lap.

    Args:
        columns: the sorties, including those that meet no mark.
        marks: number of marks.
        docks: number of docks.
        known_ms: the cost of the known lap.
    """

    def __init__(self, columns: SortieTable, marks: int, docks: int, known_ms: int) -> None:
        self._columns, self._marks, self._docks = columns, marks, docks
        self._known_ms = known_ms

    def settle(self, table: SortieTable) -> None:
        """Adds too cheap sorties from a selection, in a few passes."""
        for _ in range(_NEAR_ROUNDS):
            added = _cheapest(table, self.prices().reduced(table))
            if not len(added):
                return
            self._columns = self._columns.with_(table.of(added))

    def prices(self) -> MarkPrices:
        """The prices of the marks and docks."""
        from scipy.optimize import linprog  # 20 MB, which a waiting companion does not need

        spent(_PRICES_US)
        columns, marks, docks = self._columns, self._marks, self._docks
        count = len(columns.sets)
        numbers = np.arange(count)
        meets = (columns.sets[:, None] >> np.arange(marks) & 1).astype(float)
        covers = np.concatenate((meets, np.eye(marks)))
        balance = np.zeros((docks, count + marks))
        np.add.at(balance, (columns.origins, numbers), 1.0)
        np.add.at(balance, (columns.ends, numbers), -1.0)
        found = linprog(
            np.concatenate((columns.costs_ms.astype(float), np.full(marks, float(self._known_ms)))),
            A_ub=-covers.T,
            b_ub=-np.ones(marks),
            A_eq=balance,
            b_eq=np.zeros(docks),
            method="highs",
        )
        worth = np.floor(np.maximum(-found.ineqlin.marginals - _ROUNDED_MS, 0)).astype(np.int64)
        at_docks = np.rint(found.eqlin.marginals).astype(np.int64)
        free = columns.of(columns.sets == 0)  # no marks of theirs could make up for it
        for _ in range(docks):
            np.minimum.at(at_docks, free.origins, free.costs_ms + at_docks[free.ends])
        return MarkPrices(worth, at_docks)
