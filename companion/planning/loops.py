"""What loops does a strongly connected component of the product offer, and at what cost?

Two kinds: a component where every loop meets all marks anyway offers its shortest cycles, among
them rest; in any other a loop is a round over hits of the marks. Hits are nodes; a mark whose hits
are all hits of some other mark as well is met with that one and left out.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from companion.planning.improve import Tour
from companion.planning.product import Product
from companion.planning.rounds import FAR, MAX_WORK, Costs, Rounds, work
from companion.planning.ways import Ways

MAX_HITS = 400
"""Hits that are looked at; of more the nearest ones are, and then nothing is proved."""
MAX_CYCLES = 1000
"""Nodes whose shortest cycle is looked for, where no rest is as short as can be."""
_CHUNK = 4_000_000


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
    def is_final(self) -> bool:
        """Whether `improve` has nothing left to do."""

    @property
    def at_once(self) -> int:
        """Nodes for which `costs` should be asked together."""

    def costs(self, nodes: NDArray[np.intp]) -> Costs:
        """Cost of the shortest loop known through each of some nodes."""

    def actions(self, node: int) -> list[int]:
        """The actions of that loop, from the node on."""

    def improve(self) -> None:
        """Looks for shorter loops."""


def loops_of(product: Product, nodes: NDArray[np.intp], ways: Ways) -> Loops:
    """The loops of a component."""
    hits_of = _essential(product, nodes)
    if not hits_of:
        return Cycles(product, nodes, ways)
    return RoundTrips(nodes, hits_of, ways)


def _essential(product: Product, nodes: NDArray[np.intp]) -> list[frozenset[int]]:
    """The hits of each mark that matters."""
    every = product.all_marks
    hits_of: dict[frozenset[int], None] = {}
    for mark in range(every.bit_length()):
        hits_of[frozenset(int(n) for n in nodes if product.marks[n] >> mark & 1)] = None
    distinct = [hits for hits in hits_of if len(hits) < len(nodes)]
    return [hits for hits in distinct if not any(other < hits for other in distinct)]


class Cycles:
    """Shortest cycles, where all marks are met anyway."""

    def __init__(self, product: Product, nodes: NDArray[np.intp], ways: Ways) -> None:
        self.nodes = nodes
        self.is_final = True
        self.at_once = len(nodes)
        self._ways = ways
        inside = set(nodes.tolist())
        edges = [
            (cost, target == node)
            for node in inside
            for target, cost, _ in product.edges(node)
            if target in inside
        ]
        self.bound_ms = min(cost for cost, _ in edges)
        self._rest = {
            node: cost
            for node in inside
            for target, cost, _ in product.edges(node)
            if target == node
        }
        self.best_ms = min(self._rest.values(), default=FAR)
        if self.best_ms > self.bound_ms:
            looked_at = nodes[np.argsort(ways.arrivals[nodes], kind="stable")[:MAX_CYCLES]]
            self.best_ms = min(self.best_ms, int(self.costs(looked_at).min()))
            if len(nodes) <= MAX_CYCLES:
                self.bound_ms = self.best_ms

    def costs(self, nodes: NDArray[np.intp]) -> Costs:
        """See `Loops`."""
        return np.array([self._cost(int(node)) for node in nodes])

    def _cost(self, node: int) -> int:
        if self._rest.get(node) == self.bound_ms:
            return self.bound_ms
        (to_node,) = self._ways.to([node])
        return self._ways.turn_ms(node, to_node)

    def actions(self, node: int) -> list[int]:
        """See `Loops`."""
        (to_node,) = self._ways.to([node])
        return self._ways.actions(node, node, to_node)

    def improve(self) -> None:
        """See `Loops`."""


class RoundTrips:
    """Rounds over hits of the marks."""

    def __init__(self, nodes: NDArray[np.intp], hits_of: list[frozenset[int]], ways: Ways) -> None:
        self.nodes = nodes
        self._ways = ways
        every = sorted(frozenset().union(*hits_of))
        self._hits = _nearest(every, hits_of, ways)
        self._to_hits = ways.to(self._hits)
        self._from_hits = ways.out_of(self._hits)
        marks = np.array([[hit in hits for hits in hits_of] for hit in self._hits])
        between = self._to_hits[:, self._hits].T.copy()
        for i, hit in enumerate(self._hits):
            between[i, i] = ways.turn_ms(hit, self._to_hits[i])
        is_small = work(marks) <= MAX_WORK
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

    def costs(self, nodes: NDArray[np.intp]) -> Costs:
        """See `Loops`."""
        return self._rounds.through(self._to_hits[:, nodes], self._from_hits[:, nodes])

    def actions(self, node: int) -> list[int]:
        """See `Loops`."""
        order = self._rounds.order(self._to_hits[:, node], self._from_hits[:, node])
        taken: list[int] = []
        here = node
        for place in order:
            hit = self._hits[place]
            if hit != here:
                taken += self._ways.actions(here, hit, self._to_hits[place])
                here = hit
        if here != node or not taken:
            (to_node,) = self._ways.to([node])
            taken += self._ways.actions(here, node, to_node)
        return taken

    def improve(self) -> None:
        """See `Loops`."""
        if isinstance(self._rounds, Tour):
            self._rounds.improve()
        self.is_final = True


def _nearest(every: list[int], hits_of: list[frozenset[int]], ways: Ways) -> list[int]:
    """The hits, or if they are too many the nearest ones of each mark."""
    if len(every) <= MAX_HITS:
        return every
    share = max(1, MAX_HITS // len(hits_of))
    kept: set[int] = set()
    for hits in hits_of:
        kept.update(sorted(hits, key=lambda hit: (ways.arrivals[hit], hit))[:share])
    return sorted(kept)
