"""Shortest paths between nodes of a product, by Dijkstra's algorithm.

Among equally short paths, the one whose first actions come first in the mission file is taken.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from companion.planning.builtin.costs import UNREACHABLE_MS, Costs
from companion.planning.builtin.product import Product, dijkstra_steps
from companion.planning.effort import DIJKSTRA_STEP_US
from companion.slices import spent

_BATCH_US = 2_000
"""Time of a batch of searches; in shorter ones, the overhead of scanning the graph matters."""
_CHOICE_US = 0.4


class Edge(NamedTuple):
    """An edge of a path: the action, its cost, and the node where it ends."""

    action: int
    cost_ms: int
    end: int


class ShortestPaths:
    """The shortest paths in a product.

    Attributes:
        from_start: (nodes,) cost of the shortest path from the start to each node, or to another
            node of the same product state, from which the same continuations are possible.
        state_of: `Product.state_of` as an array.
    """

    def __init__(self, product: Product) -> None:
        self._product = product
        self._forward = product.cost_matrix()
        self._backward = self._forward.T.tocsr()
        own_costs = whole(dijkstra(self._forward, indices=product.initial, min_only=True))
        self._own_from_start = own_costs
        self.state_of = np.array(product.state_of)
        least = np.full(product.nodes, UNREACHABLE_MS)
        np.minimum.at(least, self.state_of, own_costs)
        self.from_start = least[self.state_of]

    @cached_property
    def to_facts(self) -> Costs:
        """(nodes,) cost of the shortest path from the start to the facts of each node."""
        facts_of = np.array(self._product.facts_of)
        least = np.full(len(facts_of), UNREACHABLE_MS)
        np.minimum.at(least, facts_of, self._own_from_start)
        to_facts: Costs = least[facts_of]
        return to_facts

    @cached_property
    def _node_before(self) -> list[int]:
        """The node before each node on a shortest path from the start; negative at the start."""
        start = self._product.initial
        _, before, _ = dijkstra(
            self._forward, indices=start, min_only=True, return_predecessors=True
        )
        return [int(node) for node in before]

    def passed(self, node: int) -> list[tuple[int, int]]:
        """The nodes on the shortest path from the start to a product state, without the start.

        Each comes with its cost from the start.
        """
        passed = []
        node = self._nearest_alike(node)
        while (before := self._node_before[node]) >= 0:
            passed.append((node, int(self._own_from_start[node])))
            node = before
        return passed

    def costs_to(self, goals: Sequence[int]) -> Costs:
        """Cost from every node to each goal, (goals, nodes)."""
        return costs_between(self._backward, goals)

    def costs_from(self, sources: Sequence[int]) -> Costs:
        """Cost from each source to every node, (sources, nodes)."""
        return costs_between(self._forward, sources)

    def cycle_ms(self, node: int, to_node: Costs) -> int:
        """Cost of the shortest cycle through a node, given the costs to it, (nodes,)."""
        product = self._product
        leaving = slice(product.first[node], product.first[node + 1])
        costs = product.costs[leaving] + to_node[product.ends[leaving]]
        return int(costs.min(initial=UNREACHABLE_MS))

    def path(self, start: int, goal: int, to_goal: Costs) -> list[Edge]:
        """The shortest path from a node to another; the shortest cycle if both are the same.

        Args:
            to_goal: cost from every node to the goal, (nodes,).
        """
        path: list[Edge] = []
        node = start
        while not path or node != goal:
            leaving = list(self._product.edges(node))
            spent(_CHOICE_US * len(leaving))
            action, cost, node = min(
                leaving, key=lambda edge: (edge[1] + to_goal[edge[2]], edge[0])
            )
            path.append(Edge(action, cost, node))
        return path

    def path_from_start(self, node: int) -> list[Edge]:
        """The shortest path from the start to a node, or to another node of its product state."""
        goal = self._nearest_alike(node)
        (to_goal,) = self.costs_to([goal])
        start = min(self._product.initial, key=to_goal.__getitem__)
        return self.path(start, goal, to_goal) if start != goal else []

    def _nearest_alike(self, node: int) -> int:
        """The node of the same product state that is reached first."""
        alike = np.flatnonzero(self.state_of == self.state_of[node])
        return int(alike[self._own_from_start[alike].argmin()])


def costs_between(matrix: csr_array, sources: Sequence[int]) -> Costs:
    """Cost of the shortest path from each source to every node of a graph, (sources, nodes)."""
    steps_us = DIJKSTRA_STEP_US * dijkstra_steps(matrix.shape[0], matrix.nnz)
    batch = max(1, int(_BATCH_US / steps_us))
    found = np.empty((len(sources), matrix.shape[0]), np.int64)
    for start in range(0, len(sources), batch):
        part = sources[start : start + batch]
        found[start : start + batch] = whole(dijkstra(matrix, indices=part))
        spent(steps_us * len(part))
    return found


def cheapest_edges(
    starts: NDArray[np.integer], ends: NDArray[np.integer], costs: Costs, nodes: int
) -> csr_array:
    """A graph with the cheapest edge of each pair; scipy's searches hang on duplicates."""
    order = np.lexsort((costs, ends, starts))
    pairs = np.stack((starts, ends))[:, order]
    is_new = np.append(True, (np.diff(pairs) != 0).any(axis=0))[: len(order)]
    kept = costs[order].astype(float)[is_new]
    return csr_array((kept, tuple(pairs[:, is_new])), shape=(nodes, nodes))


def whole(costs: np.ndarray) -> Costs:
    """Costs as integers, with UNREACHABLE_MS instead of infinity."""
    return np.where(np.isinf(costs), UNREACHABLE_MS, costs).astype(np.int64)
