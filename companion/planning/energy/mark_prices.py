"""Prices of marks, by which no lap costs less than all marks together.

Each mark has a price that is not negative, and each dock one of any sign. The reduced cost of a
sortie is its cost less the prices of the marks that it meets and of the dock where it begins, more
that of the dock where it ends. Around a lap the docks' prices cancel each other. So where no
reduced cost is negative, no lap costs less than the prices of all marks; and where the least is
negative, no less than that once for each sortie that there may be. This holds for any prices, and
is reckoned in whole milliseconds; so a bound does not rest on how they were found.

They are found by column generation: a linear programme over few sorties says what the marks would
be worth, the sorties that are too cheap for that are added, until there are none.

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
"""Sorties that a round adds for each pair of docks, at most."""
_KEPT = 0.7
"""Sorties of no lap that is cheaper than the known one are left out where no more are kept."""
_ROUNDED_MS = 2
"""Prices are lower than the programme says by so much, or they would be too high, rounded."""
_NEAR, _NEAR_ROUNDS = 100_000, 3
"""Of the least reduced costs: among so many sorties those are looked for, so often, that are too
cheap, before all are looked at again."""
_PRICES_US, _SORTIE_US = 5_000.0, 0.02


@dataclass(frozen=True, eq=False)
class MarkPrices:
    """Whole prices, ms.

    Attributes:
        marks: (marks,), none is negative.
        docks: (docks,).
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
        base_ms: the prices of all marks.
        reduced: (sorties,) with these prices.
        bound_ms: no lap costs less.
    """

    table: SortieTable
    base_ms: int
    reduced: Numbers
    bound_ms: int


def priced(
    table: SortieTable, marks: int, docks: int, known: Sequence[int], known_ms: int
) -> PricedSorties:
    """Prices for a bound that is as high as they can make it.

    Args:
        table: all sorties.
        marks: how many there are.
        docks: likewise.
        known: sets of marks of the sorties of a lap that is known.
        known_ms: what it costs.
    """
    most = max(1, known_ms // max(1, int(table.costs_ms.min())))  # sorties of a lap
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
    """Between each two docks, those sorties of the least reduced cost that are too cheap."""
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
    """The linear programme over some sorties; a mark may be bought for as much as a lap.

    Args:
        columns: the sorties, with those that meet nothing.
        marks: how many there are.
        docks: likewise.
        known_ms: what a lap costs.
    """

    def __init__(self, columns: SortieTable, marks: int, docks: int, known_ms: int) -> None:
        self._columns, self._marks, self._docks = columns, marks, docks
        self._known_ms = known_ms

    def settle(self, table: SortieTable) -> None:
        """Adds sorties that are too cheap among some, in a few rounds."""
        for _ in range(_NEAR_ROUNDS):
            added = _cheapest(table, self.prices().reduced(table))
            if not len(added):
                return
            self._columns = self._columns.with_(table.of(added))

    def prices(self) -> MarkPrices:
        """What the marks are worth."""
        from scipy.optimize import linprog  # 20 MB, which a companion that waits need not have

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
        free = columns.of(columns.sets == 0)  # they have no marks whose lower prices make up for it
        for _ in range(docks):
            np.minimum.at(at_docks, free.origins, free.costs_ms + at_docks[free.ends])
        return MarkPrices(worth, at_docks)
