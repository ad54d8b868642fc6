"""The loops in a strongly connected component of the product, and their costs.

There are two kinds. If every loop of a component meets all marks anyway, its loops are shortest
cycles, including rest. Otherwise a loop is a tour over targets of the marks. Targets are nodes. A
mark is left out if its targets include all those of another mark, because it is met together with
that one.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from companion.planning.builtin.costs import UNREACHABLE_MS, Costs
from companion.planning.builtin.gtsp import tours
from companion.planning.builtin.product import Product
from companion.planning.builtin.shortest_paths import Edge, ShortestPaths
from companion.planning.effort import Effort
from companion.slices import spent

_CHUNK = 400_000  # additions at once; limits memory and fits into a slice
_NODE_US = 0.1
_MAX_TARGETS = 400  # of a component; if there are more, the nearest are used


class Loops(Protocol):
    """The loops of a component."""

    @property
    def nodes(self) -> NDArray[np.intp]:
        """The nodes of the component."""

    @property
    def best_ms(self) -> int:
        """Cost of the shortest known loop."""

    @property
    def bound_ms(self) -> int:
        """A lower bound for the cost of all loops."""

    @property
    def is_exact(self) -> bool:
        """Whether `costs` are the costs of shortest loops."""

    @property
    def bottleneck_bound_ms(self) -> int:
        """A lower bound for the bottleneck of all loops."""

    def bottleneck_ms(self, loop: list[Edge]) -> int:
        """The longest time between two passes of targets of the same mark, on a loop."""

    @property
    def is_final(self) -> bool:
        """Whether `improve` has nothing left to do."""

    @property
    def batch_size(self) -> int:
        """The number of nodes for which `costs` should be called together."""

    def costs(self, nodes: NDArray[np.intp]) -> Costs:
        """Cost of the shortest known loop through each of some nodes."""

    def loop_from(self, node: int) -> list[Edge]:
        """The shortest known loop through a node, beginning there."""

    def improve(self) -> None:
        """Looks for shorter loops."""


def loops_of(
    product: Product, nodes: NDArray[np.intp], paths: ShortestPaths, effort: Effort
) -> Loops:
    """The loops of a component."""
    targets_of = essential_targets(product, nodes)
    max_targets = min(_MAX_TARGETS, max(1, effort.dijkstra_steps // product.dijkstra_steps))
    if not targets_of:
        return ShortestCycles(product, nodes, paths, max_targets)
    return TargetTours(nodes, targets_of, paths, max_targets, effort.held_karp_additions)


def essential_targets(product: Product, nodes: NDArray[np.intp]) -> list[frozenset[int]]:
    """The targets of each mark that is not always met together with another one."""
    targets_of: dict[frozenset[int], None] = {}
    for mark in range(product.all_marks.bit_length()):
        spent(_NODE_US * len(nodes))
        targets_of[frozenset(int(n) for n in nodes if product.marks[n] >> mark & 1)] = None
    distinct = [targets for targets in targets_of if len(targets) < len(nodes)]
    return [targets for targets in distinct if not any(other < targets for other in distinct)]


class ShortestCycles:
    """Shortest cycles, for components where all marks are met anyway; the interface is `Loops`.

    If no rest is as short as possible, cycles are sought through the `max_nodes` nearest nodes.
    """

    def __init__(
        self, product: Product, nodes: NDArray[np.intp], paths: ShortestPaths, max_nodes: int
    ) -> None:
        self.nodes = nodes
        self.is_final = True
        self.batch_size = len(nodes)
        self._paths = paths
        inside = set(nodes.tolist())
        spent(_NODE_US * len(product.ends))
        edges = [
            (cost, node, end)
            for node in inside
            for _, cost, end in product.edges(node)
            if end in inside
        ]
        self.bound_ms = self.bottleneck_bound_ms = min(cost for cost, _, _ in edges)
        self._rest = {node: cost for cost, node, end in edges if end == node}
        self.best_ms = min(self._rest.values(), default=UNREACHABLE_MS)
        if self.best_ms > self.bound_ms:
            nearest = nodes[np.argsort(paths.from_start[nodes], kind="stable")[:max_nodes]]
            self.best_ms = min(self.best_ms, int(self.costs(nearest).min()))
            if len(nodes) <= max_nodes:
                self.bound_ms = self.best_ms

        self.is_exact = self.best_ms == self.bound_ms

    def bottleneck_ms(self, loop: list[Edge]) -> int:
        """The longest edge of a loop, because every node meets all marks."""
        return max(edge.cost_ms for edge in loop)

    def costs(self, nodes: NDArray[np.intp]) -> Costs:
        """Cost of the shortest cycle through each of some nodes."""
        costs = np.full(len(nodes), self.bound_ms)
        moving = [i for i, n in enumerate(nodes.tolist()) if self._rest.get(n) != self.bound_ms]
        if moving:
            to_nodes = self._paths.costs_to(nodes[moving].tolist())
            for i, to_node in zip(moving, to_nodes, strict=True):
                costs[i] = self._paths.cycle_ms(int(nodes[i]), to_node)
        return costs

    def loop_from(self, node: int) -> list[Edge]:
        """The shortest cycle through a node."""
        (to_node,) = self._paths.costs_to([node])
        return self._paths.path(node, node, to_node)

    def improve(self) -> None:
        """Does nothing: these cycles are the shortest."""


class TargetTours:
    """Tours over targets of the marks; the interface is `Loops`.

    If there are more than `max_targets` targets, only the nearest of each mark are used, and
    nothing is proved.
    """

    def __init__(
        self,
        nodes: NDArray[np.intp],
        targets_of: list[frozenset[int]],
        paths: ShortestPaths,
        max_targets: int,
        max_additions: int,
    ) -> None:
        self.nodes = nodes
        self._paths = paths
        self._targets_of = targets_of
        every = sorted(frozenset().union(*targets_of))
        self._targets = _nearest(every, targets_of, paths, max_targets)
        self._to_targets = paths.costs_to(self._targets)
        self._from_targets = paths.costs_from(self._targets)
        marks = np.array([[target in group for group in targets_of] for target in self._targets])
        self._between = between = self._to_targets[:, self._targets].T.copy()
        for i, target in enumerate(self._targets):
            between[i, i] = paths.cycle_ms(target, self._to_targets[i])
        self._marks = marks
        self._tours = tours(between, marks, max_additions)
        self._has_all_targets = len(self._targets) == len(every)
        self.is_final = self._tours.is_exact
        sets = 1 << (len(targets_of) if self._tours.is_exact else 0)
        self.batch_size = max(1, _CHUNK // (len(self._targets) * sets))

    @property
    def best_ms(self) -> int:
        """Cost of the shortest known tour."""
        return self._tours.cost_ms

    @property
    def bound_ms(self) -> int:
        """A lower bound for the cost of all tours; 0 if targets were left out."""
        return self._tours.bound_ms if self._has_all_targets else 0

    def bottleneck_ms(self, loop: list[Edge]) -> int:
        """The longest time between two passes of targets of the same mark."""
        return max(_longest_gap_ms(loop, targets) for targets in self._targets_of)

    @property
    def is_exact(self) -> bool:
        """Whether all targets are used and the tours over them are exact."""
        return self._has_all_targets and self._tours.is_exact

    @property
    def bottleneck_bound_ms(self) -> int:
        """A lower bound for the bottleneck of all tours.

        If each mark has one target, the longest gap begins and ends at one target and passes all
        others, so it is a tour. If a mark has several targets, its gap is at least the path between
        the nearest two of them, or from one back to itself.
        """
        if not self._has_all_targets:
            return 0
        if all(len(targets) == 1 for targets in self._targets_of):
            return self._tours.bound_ms
        places = [np.flatnonzero(column) for column in self._marks.T]
        return max(int(self._between[np.ix_(at, at)].min()) for at in places)

    def costs(self, nodes: NDArray[np.intp]) -> Costs:
        """Cost of the shortest known tour through each of some nodes."""
        return self._tours.costs_through(self._to_targets[:, nodes], self._from_targets[:, nodes])

    def loop_from(self, node: int) -> list[Edge]:
        """The shortest known tour through a node, beginning there."""
        order = self._tours.order_after(self._to_targets[:, node], self._from_targets[:, node])
        loop: list[Edge] = []
        here = node
        for place in order:
            target = self._targets[place]
            if target != here:
                loop += self._paths.path(here, target, self._to_targets[place])
                here = target
        if here != node or not loop:
            (to_node,) = self._paths.costs_to([node])
            loop += self._paths.path(here, node, to_node)
        return loop

    def improve(self) -> None:
        """Looks for shorter tours."""
        self._tours.improve()
        self.is_final = True


def _nearest(
    every: list[int], targets_of: list[frozenset[int]], paths: ShortestPaths, max_targets: int
) -> list[int]:
    """The targets; if there are too many, the nearest ones of each mark."""
    if len(every) <= max_targets:
        return every
    share = max(1, max_targets // len(targets_of))
    kept: set[int] = set()
    for targets in targets_of:
        kept.update(sorted(targets, key=lambda node: (paths.from_start[node], node))[:share])
    return sorted(kept)


def _longest_gap_ms(loop: list[Edge], targets: frozenset[int]) -> int:
    """The longest time between two passes of some targets on a loop that is repeated for ever."""
    elapsed_ms = np.cumsum([edge.cost_ms for edge in loop])
    met = elapsed_ms[[edge.end in targets for edge in loop]]
    return int(np.diff(met, append=met[0] + elapsed_ms[-1]).max())
