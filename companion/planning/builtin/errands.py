"""In which order is it best to meet what has to be met once, on the way to a loop?

`F at(A) & F at(B) & ...` doubles the product with each site. These errands are left out of the
product; a prefix is then a way from the start over a place of each of them to a node of a loop.
That is a round through one more hit, which stands for the loop and leads back to the start, so
it is found as rounds are: exactly for few errands, well for many.

The errands are done when the loop begins, as in the whole product; that the loop may do some of
them in its first lap is not made use of.
"""

from __future__ import annotations

import numpy as np

from companion.planning.builtin.improve import Tour
from companion.planning.builtin.product import Product, SearchLimit
from companion.planning.builtin.rounds import FAR, Costs, Rounds, work
from companion.planning.builtin.ways import Stride, Ways
from companion.planning.effort import Effort


class Errands:
    """The ways from the start over all errands to a loop.

    Args:
        product: with the errands.
        ways: of the product.
        loop_costs: what a loop from each node is worth, (nodes,); FAR where none begins.
        effort: how much the answer may cost.

    Raises:
        SearchLimit: there are too many nodes that do errands.
    """

    def __init__(
        self,
        product: Product,
        ways: Ways,
        loop_costs: Costs,
        effort: Effort,
    ) -> None:
        places, roots = product.errands, product.roots
        self._ways = ways
        self._hits = sorted(set().union(*places))
        if len(self._hits) * len(product.targets) > effort.ways:
            raise SearchLimit(f"no plan found: {len(self._hits)} product states to visit")
        self._loop_costs = loop_costs
        to_hits = ways.to(self._hits)
        self._to_hits = to_hits
        size = len(self._hits)
        between = np.full((size + 1, size + 1), FAR)
        between[:size, :size] = to_hits[:, self._hits].T
        starts = to_hits[:, roots]
        for i, hit in enumerate(self._hits):
            between[i, i] = ways.turn_ms(hit, to_hits[i])
            starts[i, [root == hit for root in roots]] = between[i, i]
        between[size, :size] = starts.min(axis=1)
        ends = ways.out_of(self._hits) + loop_costs
        between[:size, size] = np.minimum(ends.min(axis=1), FAR)
        self._roots = [roots[i] for i in starts.argmin(axis=1)]
        self._entries = ends.argmin(axis=1)
        marks = np.zeros((size + 1, len(places) + 1), np.bool_)
        for column, nodes in enumerate(places):
            marks[[self._hits.index(node) for node in nodes], column] = True
        marks[size, -1] = True
        is_small = work(marks) <= effort.additions
        self._rounds: Rounds | Tour = (Rounds if is_small else Tour)(between, marks)
        self.is_final = self.is_exact = is_small

    @property
    def cost_ms(self) -> int:
        """Of the best way that is known, with what its loop is worth."""
        return self._rounds.cost_ms

    def improve(self) -> None:
        """Looks for a better way."""
        if isinstance(self._rounds, Tour):
            self._rounds.improve()
        self.is_final = True

    def walk(self) -> tuple[list[Stride], int]:
        """The best way that is known, and the node where its loop begins."""
        cycle = self._rounds.cycle()
        start = cycle.index(len(self._hits)) + 1
        first, *rest = cycle[start:] + cycle[: start - 1]
        here = self._roots[first]
        strides: list[Stride] = []
        for place in (first, *rest):
            hit = self._hits[place]
            strides += self._ways.walk(here, hit, self._to_hits[place])
            here = hit
        entry = int(self._entries[rest[-1] if rest else first])
        if entry != here:
            (to_entry,) = self._ways.to([entry])
            strides += self._ways.walk(here, entry, to_entry)
        return strides, entry
