"""What is the shortest way round that meets every mark? Exact, by dynamic programming.

A loop of a plan is a closed walk that passes a node of every mark (a *hit*). Between two hits it
takes the shortest way, so the choice is the order of the hits: the generalised travelling
salesman problem, and with one hit to a mark (a patrol) the travelling salesman problem itself.
Every round passes a hit of the rarest mark, its anchor. Two tables per anchor, of the best way
on to the anchor and of the best way from it, give the shortest round through any node.

Source: Held and Karp, A dynamic programming approach to sequencing problems, 1962.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

Costs = NDArray[np.int64]
FAR = 1 << 50
"""No way; thousands of these can be added."""

_CHUNK = 2_000_000  # additions at once; bounds memory


def work(marks: NDArray[np.bool_]) -> int:
    """Additions that the tables need."""
    hits, kinds = marks.shape
    work: int = 2 * int(marks.sum(axis=0).min()) * hits * hits << kinds - 1
    return work


class Rounds:
    """All shortest rounds over some hits.

    Attributes:
        cost_ms: of the shortest round.
        bound_ms: the same.

    Args:
        between: cost of the shortest way with at least one step from a hit to a hit, (H, H).
        marks: which marks each hit has, (H, K).
    """

    def __init__(self, between: Costs, marks: NDArray[np.bool_]) -> None:
        anchors = np.flatnonzero(marks[:, marks.sum(axis=0).argmin()])  # hits of the rarest mark
        bits = marks @ (1 << np.arange(marks.shape[1]))
        self._tables = [_Tables(between, bits, anchor) for anchor in anchors]
        self.cost_ms = self.bound_ms = min(table.cost_ms for table in self._tables)

    def through(self, to_hits: Costs, from_hits: Costs) -> Costs:
        """Cost of the shortest round through nodes that are no hits, or hits, (V,).

        Args:
            to_hits: cost from each node to each hit, (H, V).
            from_hits: cost from each hit to each node, (H, V).
        """
        found = [table.through(to_hits, from_hits)[0] for table in self._tables]
        shortest: Costs = np.min(found, axis=0)
        return shortest

    def cycle(self) -> list[int]:
        """The hits of a shortest round, from any of them on."""
        return min(self._tables, key=lambda table: table.cost_ms).cycle()

    def order(self, to_hits: Costs, from_hits: Costs) -> list[int]:
        """The hits of the shortest round through one node, in the order they follow it.

        Args:
            to_hits: cost from the node to each hit, (H,).
            from_hits: cost from each hit to the node, (H,).
        """
        columns = to_hits[:, None], from_hits[:, None]
        costs = [table.through(*columns)[0][0] for table in self._tables]
        return self._tables[int(np.argmin(costs))].order(to_hits, from_hits)


class _Tables:
    """The shortest rounds over an anchor."""

    def __init__(self, between: Costs, marks: NDArray[np.int64], anchor: np.intp) -> None:
        left = _compressed(marks, int(marks[anchor]))
        self._others = np.flatnonzero(left)
        self._anchor = int(anchor)
        self._marks = left[self._others]
        self._every = int(np.bitwise_or.reduce(self._marks, initial=0))
        inner = between[np.ix_(self._others, self._others)]
        self._inner = inner
        self._first = between[anchor]
        self._turn_ms = int(between[anchor, anchor])
        self._onward = _table(inner, self._marks, between[self._others, anchor])
        self._inward = _table(inner.T, self._marks, between[anchor, self._others])
        if self._every:
            onward = self._onward[self._marks, np.arange(len(self._others))]
            self.cost_ms = int((between[anchor, self._others] + onward).min())
        else:
            self.cost_ms = self._turn_ms

    def through(self, to_hits: Costs, from_hits: Costs) -> tuple[Costs, NDArray[np.intp]]:
        """Cost of the shortest round through each node, and what is met before the node.

        The second figure is a set of marks (bits): met from the anchor to the node.
        """
        before = self._parts(self._inward, from_hits)
        after = self._parts(self._onward, to_hits)[::-1]  # complements
        total = before + after
        left = self._every - total[::-1].argmin(axis=0)  # of equal ones, meet most afterwards
        costs = total[left, np.arange(total.shape[1])]
        if not self._every:  # at the anchor itself the way there and back is empty
            costs = np.where(costs == 0, self._turn_ms, costs)
        return costs, left

    def _parts(self, table: Costs, ways: Costs) -> Costs:
        """Cost of the part between node and anchor by what is not met on it, (sets, V)."""
        sets = np.arange(self._every + 1)
        reached = table[sets[:, None] | self._marks, np.arange(len(self._others))]
        legs = ways[self._others]
        costs = np.full((len(sets), ways.shape[1]), FAR)
        for hit in range(len(self._others)):
            np.minimum(costs, reached[:, hit, None] + legs[hit], out=costs)
        costs[-1] = np.minimum(costs[-1], ways[self._anchor])
        return costs

    def cycle(self) -> list[int]:
        """The hits of the shortest round, from the anchor on."""
        onward = self._walk(self._onward, self._inner, self._first, 0) if self._every else []
        return [self._anchor, *onward]

    def order(self, to_hits: Costs, from_hits: Costs) -> list[int]:
        """The hits of the shortest round through a node, in the order they follow it."""
        _, left = self.through(to_hits[:, None], from_hits[:, None])
        unmet = int(left[0])  # on the way from the anchor to the node
        after = self._walk(self._onward, self._inner, to_hits, self._every ^ unmet)
        before = self._walk(self._inward, self._inner.T, from_hits, unmet)
        return [*after, self._anchor, *reversed(before)]

    def _walk(self, table: Costs, inner: Costs, ways: Costs, met: int) -> list[int]:
        """The hits between a node and the anchor, by the best choice at each."""
        walked: list[int] = []
        legs = ways[self._others]
        hits = np.arange(len(self._others))
        if met == self._every and (
            not len(hits) or ways[self._anchor] <= (legs + table[met | self._marks, hits]).min()
        ):
            return []
        while True:
            following = met | self._marks
            costs = legs + table[following, hits]
            if walked:
                costs = np.where(following == met, FAR, costs)
            best = int(costs.argmin())
            walked.append(int(self._others[best]))
            met = int(following[best])
            if met == self._every:
                return walked
            legs = inner[best]


def _compressed(marks: NDArray[np.int64], met: int) -> NDArray[np.int64]:
    """Marks without those that are met, the others renumbered from 0."""
    every = int(np.bitwise_or.reduce(marks))
    kept = [bit for bit in range(every.bit_length()) if every >> bit & 1 and not met >> bit & 1]
    found = np.zeros_like(marks)
    for new, bit in enumerate(kept):
        found |= (marks >> bit & 1) << new
    return found


def _table(between: Costs, marks: NDArray[np.int64], last: Costs) -> Costs:
    """Cost from each hit, by the marks that are met there, to meet the others and end.

    Args:
        between: cost from hit to hit, (H, H).
        marks: of each hit, none of them 0, (H,).
        last: cost from each hit to the end, (H,).

    Returns:
        Costs by set of marks and hit, (2^k, H).
    """
    every = int(np.bitwise_or.reduce(marks, initial=0))
    hits = np.arange(len(marks))
    table = np.full((every + 1, len(marks)), FAR)
    table[every] = last
    if not every:
        return table
    rows = max(1, _CHUNK // len(marks) ** 2)
    for layer in _layers(every.bit_length()):
        for start in range(0, len(layer), rows):
            sets = layer[start : start + rows, None]
            following = sets | marks
            onward = np.where(following == sets, FAR, table[following, hits])
            table[sets[:, 0]] = (onward[:, None, :] + between).min(axis=2)
    return table


@cache
def _layers(bits: int) -> tuple[NDArray[np.int64], ...]:
    """All sets but the full one, those of equal size together, the largest first."""
    sets = np.arange((1 << bits) - 1)
    sizes = sum((sets >> bit & 1 for bit in range(bits)), start=np.zeros_like(sets))
    return tuple(sets[sizes == size] for size in range(bits - 1, -1, -1))
