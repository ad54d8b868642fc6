"""Held and Karp's dynamic programme: exact tours of the generalised travelling salesman problem.

For each set of marks that are already met, a table gives the cheapest path from each target to an
anchor. Every tour passes a target of the rarest mark, so these are the anchors. For each anchor
there are two tables, of the paths to it and from it; together they give the shortest tour through
any node.

Source: Held and Karp, A dynamic programming approach to sequencing problems, 1962.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from companion.planning.builtin.costs import UNREACHABLE_MS, Costs, Marks
from companion.planning.effort import ADDITION_US
from companion.slices import spent

_CHUNK = 400_000  # additions at once; limits memory and fits into a slice


def table_additions(marks: Marks) -> int:
    """The number of additions that fill the tables, which is their cost.

    >>> table_additions(np.eye(17, dtype=np.bool_))  # a patrol over 17 sites
    37879808
    """
    targets, kinds = marks.shape
    additions: int = 2 * int(marks.sum(axis=0).min()) * targets * targets << kinds - 1
    return additions


class HeldKarp:
    """The shortest tours over some targets; the interface is `Tours`.

    Attributes:
        cost_ms: cost of the shortest tour.
        bound_ms: the same value.

    Args:
        between: cost of the shortest path with at least one edge from target to target, (T, T).
        marks: marks of the targets, (T, M).

    >>> between = np.array([[9, 1, 4], [5, 9, 2], [3, 6, 9]])
    >>> tours = HeldKarp(between, np.eye(3, dtype=np.bool_))
    >>> tours.cost_ms, tours.cycle()
    (6, [0, 1, 2])
    """

    is_exact = True

    def __init__(self, between: Costs, marks: Marks) -> None:
        anchors = np.flatnonzero(marks[:, marks.sum(axis=0).argmin()])  # of the rarest mark
        bits = marks @ (1 << np.arange(marks.shape[1]))
        self._tables = [_Tables(between, bits, anchor) for anchor in anchors]
        self.cost_ms = self.bound_ms = min(table.cost_ms for table in self._tables)

    def improve(self) -> None:
        """Does nothing, because no tour is shorter."""

    def costs_through(self, to_targets: Costs, from_targets: Costs) -> Costs:
        """Cost of the shortest tour through each of some nodes, (V,).

        Args:
            to_targets: cost from each node to each target, (T, V).
            from_targets: cost from each target to each node, (T, V).
        """
        found = [table.costs_through(to_targets, from_targets)[0] for table in self._tables]
        shortest: Costs = np.min(found, axis=0)
        return shortest

    def cycle(self) -> list[int]:
        """The targets of a shortest tour, beginning with any of them."""
        return min(self._tables, key=lambda table: table.cost_ms).cycle()

    def order_after(self, to_targets: Costs, from_targets: Costs) -> list[int]:
        """The targets of the shortest tour through a node, in the order in which they follow it.

        Args:
            to_targets: cost from the node to each target, (T,).
            from_targets: cost from each target to the node, (T,).
        """
        to_column, from_column = to_targets[:, None], from_targets[:, None]
        costs = [table.costs_through(to_column, from_column)[0][0] for table in self._tables]
        return self._tables[int(np.argmin(costs))].order_after(to_targets, from_targets)


class _Tables:
    """The shortest tours through one anchor.

    Sets of marks are bits, without the anchor's own marks.
    """

    def __init__(self, between: Costs, marks: NDArray[np.int64], anchor: np.intp) -> None:
        remaining = _renumbered(marks, int(marks[anchor]))
        self._others = np.flatnonzero(remaining)
        self._anchor = int(anchor)
        self._marks = remaining[self._others]
        self._all_marks = int(np.bitwise_or.reduce(self._marks, initial=0))
        inner = between[np.ix_(self._others, self._others)]
        self._inner = inner
        self._from_anchor = between[anchor]
        self._cycle_ms = int(between[anchor, anchor])
        self._onward = _table(inner, self._marks, between[self._others, anchor])
        self._inward = _table(inner.T, self._marks, between[anchor, self._others])
        if self._all_marks:
            onward = self._onward[self._marks, np.arange(len(self._others))]
            self.cost_ms = int((between[anchor, self._others] + onward).min())
        else:
            self.cost_ms = self._cycle_ms

    def costs_through(
        self, to_targets: Costs, from_targets: Costs
    ) -> tuple[Costs, NDArray[np.intp]]:
        """Cost of the shortest tour through each node, and the marks that it meets after the node.

        The second value is a set of marks: those met on the part from the node to the anchor.
        """
        before = self._part_costs(self._inward, from_targets)
        after = self._part_costs(self._onward, to_targets)[::-1]  # complements
        total = before + after
        left = self._all_marks - total[::-1].argmin(axis=0)  # of equal ones, meet most afterwards
        costs = total[left, np.arange(total.shape[1])]
        if not self._all_marks:  # at the anchor itself the path there and back is empty
            costs = np.where(costs == 0, self._cycle_ms, costs)
        return costs, left

    def _part_costs(self, table: Costs, legs: Costs) -> Costs:
        """Cost of the part between node and anchor, by the marks not met on it, (sets, V)."""
        sets = np.arange(self._all_marks + 1)
        reached = table[sets[:, None] | self._marks, np.arange(len(self._others))]
        other_legs = legs[self._others]
        costs = np.full((len(sets), legs.shape[1]), UNREACHABLE_MS)
        for target in range(len(self._others)):
            spent(ADDITION_US * costs.size)
            np.minimum(costs, reached[:, target, None] + other_legs[target], out=costs)
        costs[-1] = np.minimum(costs[-1], legs[self._anchor])
        return costs

    def cycle(self) -> list[int]:
        """The targets of the shortest tour, from the anchor on."""
        if not self._all_marks:
            return [self._anchor]
        return [self._anchor, *self._traced(self._onward, self._inner, self._from_anchor, 0)]

    def order_after(self, to_targets: Costs, from_targets: Costs) -> list[int]:
        """The targets of the shortest tour through a node, in the order in which they follow it."""
        _, left = self.costs_through(to_targets[:, None], from_targets[:, None])
        met_after = int(left[0])
        met_before = self._all_marks ^ met_after
        after = self._traced(self._onward, self._inner, to_targets, met_before)
        before = self._traced(self._inward, self._inner.T, from_targets, met_after)
        return [*after, self._anchor, *reversed(before)]

    def _traced(self, table: Costs, inner: Costs, legs: Costs, met: int) -> list[int]:
        """The targets between a node and the anchor, with the best choice at each step."""
        traced: list[int] = []
        next_legs = legs[self._others]
        targets = np.arange(len(self._others))
        if met == self._all_marks and (
            not len(targets)
            or legs[self._anchor] <= (next_legs + table[met | self._marks, targets]).min()
        ):
            return []
        while True:
            following = met | self._marks
            costs = next_legs + table[following, targets]
            if traced:
                costs = np.where(following == met, UNREACHABLE_MS, costs)
            best = int(costs.argmin())
            traced.append(int(self._others[best]))
            met = int(following[best])
            if met == self._all_marks:
                return traced
            next_legs = inner[best]


def _renumbered(marks: NDArray[np.int64], met: int) -> NDArray[np.int64]:
    """The marks without those that are met, with the others renumbered from 0."""
    every = int(np.bitwise_or.reduce(marks))
    kept = [bit for bit in range(every.bit_length()) if every >> bit & 1 and not met >> bit & 1]
    found = np.zeros_like(marks)
    for new, bit in enumerate(kept):
        found |= (marks >> bit & 1) << new
    return found


def _table(between: Costs, marks: NDArray[np.int64], last: Costs) -> Costs:
    """Cost from each target to the end, by the set of marks that are met there, meeting the others.

    Args:
        between: cost from target to target, (T, T).
        marks: marks of each target, as bits, none of them 0, (T,).
        last: cost from each target to the end, (T,).

    Returns:
        Costs by set of marks and target, (2^k, T).
    """
    every = int(np.bitwise_or.reduce(marks, initial=0))
    targets = np.arange(len(marks))
    table = np.full((every + 1, len(marks)), UNREACHABLE_MS)
    table[every] = last
    if not every:
        return table
    rows = max(1, _CHUNK // len(marks) ** 2)
    for layer in _layers(every.bit_length()):
        for start in range(0, len(layer), rows):
            sets = layer[start : start + rows, None]
            following = sets | marks
            onward = np.where(following == sets, UNREACHABLE_MS, table[following, targets])
            table[sets[:, 0]] = (onward[:, None, :] + between).min(axis=2)
            spent(ADDITION_US * onward.size * len(marks))
    return table


@cache
def _layers(bits: int) -> tuple[NDArray[np.int64], ...]:
    """All sets except the full one, grouped by size, the largest first."""
    sets = np.arange((1 << bits) - 1)
    sizes = sum((sets >> bit & 1 for bit in range(bits)), start=np.zeros_like(sets))
    return tuple(sets[sizes == size] for size in range(bits - 1, -1, -1))
