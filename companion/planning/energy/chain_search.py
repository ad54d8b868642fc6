"""Finds the cheapest closed chain of sorties that meets every mark, by reduced costs.

With prices of marks (`mark_prices.py`), the cost of a lap is the price of all marks plus the
reduced costs of its sorties, which are never negative. So with good prices a best-first search by
reduced costs examines few chains: those that are hardly more expensive than the best. A chain
begins with a sortie that meets the first mark, because each lap has one. It meets no mark twice,
because that is never cheaper (`sortie_table.py`).

Source: Baldacci, Christofides and Mingozzi, An exact algorithm for the vehicle routing problem
based on the set partitioning formulation with additional cuts, 2008: sorties left by their reduced
costs, and a search over them.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np

from companion.planning.energy.mark_prices import PricedSorties
from companion.slices import spent

MOST_SORTIES = 1_500_000_000
"""The most sorties to try, one at the end of each chain; this takes some seconds."""
_CHAINS_SORTIES = 2_000
"""A chain takes as long as this many sorties."""
_CHAIN_US, _SORTIE_US = 20.0, 0.01


@dataclass(frozen=True, slots=True)
class ChainFound:
    """The result of a search.

    Attributes:
        sorties: those of the cheapest lap, as indices in the priced table; None if no lap is
            cheaper than the known one.
        bound_ms: a lower bound for the cost of all laps.
    """

    sorties: tuple[int, ...] | None
    bound_ms: int


_State = tuple[int, int, int]
"""The dock where a chain begins, the dock where it ends, and the marks that it meets."""


class ChainSearch:
    """A search among priced sorties.

    Args:
        priced: all sorties of laps that cost less than the known one.
        marks: number of marks.
        known_ms: cost of a known lap.
    """

    def __init__(self, priced: PricedSorties, marks: int, known_ms: int) -> None:
        self._priced, self._every, self._known_ms = priced, (1 << marks) - 1, known_ms
        self._gap = known_ms - priced.base_ms
        order = np.argsort(priced.reduced, kind="stable")
        order = order[priced.reduced[order] < self._gap]
        table = priced.table.of(order)
        docks = 1 + int(max(table.origins.max(initial=0), table.ends.max(initial=0)))
        self._of_dock = [order[table.origins == dock] for dock in range(docks)]
        self._sorties = [table.of(table.origins == dock) for dock in range(docks)]
        self._reduced = [priced.reduced[own] for own in self._of_dock]
        self._left = MOST_SORTIES
        self._pending: list[tuple[int, int, _State]] = []
        self._best: dict[_State, int] = {}
        self._before: dict[_State, tuple[_State | None, int]] = {}

    def best(self) -> ChainFound:
        """The cheapest lap, if it costs less than the known one."""
        if self._priced.reduced.min(initial=0) < 0:
            return ChainFound(None, self._priced.bound_ms)
        for dock in range(len(self._of_dock)):
            self._extend(0, (dock, dock, 0), None)
        while self._left > 0:
            if not self._pending:
                return ChainFound(None, self._known_ms)
            cost, _, state = heapq.heappop(self._pending)
            start, here, met = state
            if met == self._every and here == start:
                return ChainFound(self._read(state), self._priced.base_ms + cost)
            if cost == self._best[state]:
                self._extend(cost, state, state)
        least = min((cost for cost, _, _ in self._pending), default=self._gap)
        return ChainFound(None, self._priced.base_ms + least)

    def _extend(self, cost: int, state: _State, before: _State | None) -> None:
        """Adds one more sortie to chains; the first sortie meets the first mark."""
        start, here, met = state
        reduced, table = self._reduced[here], self._sorties[here]
        count = int(np.searchsorted(reduced, self._gap - cost))
        sets = table.sets[:count]
        is_next = (sets & met) == 0 if before else (sets & 1) == 1
        spent(_CHAIN_US + _SORTIE_US * count)
        self._left -= _CHAINS_SORTIES + count
        for place in np.flatnonzero(is_next).tolist():
            after = start, int(table.ends[place]), met | int(sets[place])
            total = cost + int(reduced[place])
            if total < self._best.get(after, self._gap):
                self._best[after] = total
                self._before[after] = before, int(self._of_dock[here][place])
                heapq.heappush(self._pending, (total, len(self._before), after))

    def _read(self, state: _State) -> tuple[int, ...]:
        """The sorties of a chain, in their order."""
        found = []
        at: _State | None = state
        while at is not None:
            at, sortie = self._before[at]
            found.append(sortie)
        return tuple(found[::-1])
