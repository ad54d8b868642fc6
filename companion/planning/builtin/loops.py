"""What loops does a strongly connected component of the product offer, and at what cost?

Two kinds: a component where every loop meets all marks anyway offers its shortest cycles, among
them rest; in any other a loop is a round over hits of the marks. Hits are nodes; a mark whose hits
are all hits of some other mark as well is met with that one and left out.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from companion.planning.builtin.improve import Tour
from companion.planning.builtin.product import Product
from companion.planning.builtin.rounds import FAR, Costs, Rounds, work
from companion.planning.builtin.ways import Stride, Ways
from companion.planning.effort import Effort

_CHUNK = 4_000_000  # additions at once; bounds memory
_MOST = 400  # hits that are ever looked at


class Loops(Protocol):
    """The loops of a component."""

    @property
    def nodes(self) -> NDArray[np.intp]:
        """The nodes of the component."""

    @property
    def best_ms(self) -> int:
        """Cost of the shortest loop that is known."""

    @property
    def bound_ms(self) -> int:
        """No loop is shorter."""

    @property
    def is_exact(self) -> bool:
        """Whether `costs` are those of the shortest loops."""

    @property
    def wait_bound_ms(self) -> int:
        """On no loop is that shorter."""

    def wait_ms(self, strides: list[Stride]) -> int:
        """The longest time between two hits of the same mark on one of the loops."""

    @property
    def is_final(self) -> bool:
        """Whether `improve` has nothing left to do."""

    @property
    def at_once(self) -> int:
        """Nodes for which `costs` should be asked together."""

    def costs(self, nodes: NDArray[np.intp]) -> Costs:
        """Cost of the shortest loop known through each of some nodes."""

    def walk(self, node: int) -> list[Stride]:
        """That loop, from the node on."""

    def improve(self) -> None:
        """Looks for shorter loops."""


def loops_of(product: Product, nodes: NDArray[np.intp], ways: Ways, effort: Effort) -> Loops:
    """The loops of a component."""
    hits_of = _essential(product, nodes)
    most = min(_MOST, max(1, effort.ways // len(product.targets)))
    if not hits_of:
        return Cycles(product, nodes, ways, most)
    return RoundTrips(nodes, hits_of, ways, most, effort.additions)


def _essential(product: Product, nodes: NDArray[np.intp]) -> list[frozenset[int]]:
    """The hits of each mark that matters."""
    every = product.all_marks
    hits_of: dict[frozenset[int], None] = {}
    for mark in range(every.bit_length()):
        hits_of[frozenset(int(n) for n in nodes if product.marks[n] >> mark & 1)] = None
    distinct = [hits for hits in hits_of if len(hits) < len(nodes)]
    return [hits for hits in distinct if not any(other < hits for other in distinct)]


class Cycles:
    """Shortest cycles, where all marks are met anyway.

    If no rest is as short as can be, cycles are looked for through the `most` nearest nodes.
    """

    def __init__(self, product: Product, nodes: NDArray[np.intp], ways: Ways, most: int) -> None:
        self.nodes = nodes
        self.is_final = True
        self.at_once = len(nodes)
        self._ways = ways
        inside = set(nodes.tolist())
        edges = [
            (cost, node, target)
            for node in inside
            for target, cost, _ in product.edges(node)
            if target in inside
        ]
        self.bound_ms = self.wait_bound_ms = min(cost for cost, _, _ in edges)
        self._rest = {node: cost for cost, node, target in edges if target == node}
        self.best_ms = min(self._rest.values(), default=FAR)
        if self.best_ms > self.bound_ms:
            looked_at = nodes[np.argsort(ways.arrivals[nodes], kind="stable")[:most]]
            self.best_ms = min(self.best_ms, int(self.costs(looked_at).min()))
            if len(nodes) <= most:
                self.bound_ms = self.best_ms

        self.is_exact = self.best_ms == self.bound_ms

    def wait_ms(self, strides: list[Stride]) -> int:
        """See `Loops`."""
        return max(stride.cost_ms for stride in strides)

    def costs(self, nodes: NDArray[np.intp]) -> Costs:
        """See `Loops`."""
        return np.array([self._cost(int(node)) for node in nodes])

    def _cost(self, node: int) -> int:
        if self._rest.get(node) == self.bound_ms:
            return self.bound_ms
        (to_node,) = self._ways.to([node])
        return self._ways.turn_ms(node, to_node)

    def walk(self, node: int) -> list[Stride]:
        """See `Loops`."""
        (to_node,) = self._ways.to([node])
        return self._ways.walk(node, node, to_node)

    def improve(self) -> None:
        """See `Loops`."""


class RoundTrips:
    """Rounds over hits of the marks.

    Of more than `most` hits the nearest of each mark are looked at, and then nothing is proved.
    """

    def __init__(
        self,
        nodes: NDArray[np.intp],
        hits_of: list[frozenset[int]],
        ways: Ways,
        most: int,
        additions: int,
    ) -> None:
        self.nodes = nodes
        self._ways = ways
        self._hits_of = hits_of
        every = sorted(frozenset().union(*hits_of))
        self._hits = _nearest(every, hits_of, ways, most)
        self._to_hits = ways.to(self._hits)
        self._from_hits = ways.out_of(self._hits)
        marks = np.array([[hit in hits for hits in hits_of] for hit in self._hits])
        self._between = between = self._to_hits[:, self._hits].T.copy()
        for i, hit in enumerate(self._hits):
            between[i, i] = ways.turn_ms(hit, self._to_hits[i])
        self._marks = marks
        is_small = work(marks) <= additions
        self._rounds: Rounds | Tour = (Rounds if is_small else Tour)(between, marks)
        self._has_all_hits = len(self._hits) == len(every)
        self.is_final = is_small
        self.at_once = max(1, _CHUNK // (len(self._hits) << (len(hits_of) if is_small else 0)))

    @property
    def best_ms(self) -> int:
        """See `Loops`."""
        return self._rounds.cost_ms

    @property
    def bound_ms(self) -> int:
        """See `Loops`."""
        return self._rounds.bound_ms if self._has_all_hits else 0

    def wait_ms(self, strides: list[Stride]) -> int:
        """See `Loops`."""
        return max(_longest_wait_ms(strides, hits) for hits in self._hits_of)

    @property
    def is_exact(self) -> bool:
        """See `Loops`."""
        return self._has_all_hits and isinstance(self._rounds, Rounds)

    @property
    def wait_bound_ms(self) -> int:
        """See `Loops`.

        Where each mark has one hit, somewhere the longest wait begins and ends at one hit and
        passes all others, so it is a round. Where a mark has several, it is at least as long as
        the way between the nearest two of them, or from one back to itself.
        """
        if not self._has_all_hits:
            return 0
        if all(len(hits) == 1 for hits in self._hits_of):
            return self._rounds.bound_ms
        places = [np.flatnonzero(column) for column in self._marks.T]
        return max(int(self._between[np.ix_(at, at)].min()) for at in places)

    def costs(self, nodes: NDArray[np.intp]) -> Costs:
        """See `Loops`."""
        return self._rounds.through(self._to_hits[:, nodes], self._from_hits[:, nodes])

    def walk(self, node: int) -> list[Stride]:
        """See `Loops`."""
        order = self._rounds.order(self._to_hits[:, node], self._from_hits[:, node])
        taken: list[Stride] = []
        here = node
        for place in order:
            hit = self._hits[place]
            if hit != here:
                taken += self._ways.walk(here, hit, self._to_hits[place])
                here = hit
        if here != node or not taken:
            (to_node,) = self._ways.to([node])
            taken += self._ways.walk(here, node, to_node)
        return taken

    def improve(self) -> None:
        """See `Loops`."""
        if isinstance(self._rounds, Tour):
            self._rounds.improve()
        self.is_final = True


def _nearest(every: list[int], hits_of: list[frozenset[int]], ways: Ways, most: int) -> list[int]:
    """The hits, or if they are too many the nearest ones of each mark."""
    if len(every) <= most:
        return every
    share = max(1, most // len(hits_of))
    kept: set[int] = set()
    for hits in hits_of:
        kept.update(sorted(hits, key=lambda hit: (ways.arrivals[hit], hit))[:share])
    return sorted(kept)


def _longest_wait_ms(strides: list[Stride], hits: frozenset[int]) -> int:
    """The longest time between two hits on a loop that is repeated for ever."""
    ends = np.cumsum([stride.cost_ms for stride in strides])
    met = ends[[stride.node in hits for stride in strides]]
    return int(np.diff(met, append=met[0] + ends[-1]).max())
