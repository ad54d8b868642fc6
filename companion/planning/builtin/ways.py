"""How far is it between nodes of a product, and by which actions? Dijkstra's algorithm.

Of equally short ways the one whose first actions come first in the mission file is taken.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.sparse.csgraph import dijkstra

from companion.planning.builtin.product import Product
from companion.planning.builtin.rounds import FAR, Costs


class Stride(NamedTuple):
    """One step of a way."""

    action: int
    cost_ms: int
    node: int


class Ways:
    """Shortest ways in a product.

    Attributes:
        arrivals: cost of the shortest way from the start to each node, or to a node after which
            the same can be done.
        twins: `Product.twins`.
    """

    def __init__(self, product: Product) -> None:
        self._product = product
        self._forward = product.graph()
        self._backward = self._forward.T.tocsr()
        raw = _whole(dijkstra(self._forward, indices=product.roots, min_only=True))
        self._raw_arrivals = raw
        self.twins = np.array(product.twins)
        least = np.full(product.nodes, FAR)
        np.minimum.at(least, self.twins, raw)
        self.arrivals = least[self.twins]

    def to(self, goals: Sequence[int]) -> Costs:
        """Cost from every node to each goal, (goals, nodes)."""
        return _whole(dijkstra(self._backward, indices=goals))

    def out_of(self, sources: Sequence[int]) -> Costs:
        """Cost from each source to every node, (sources, nodes)."""
        return _whole(dijkstra(self._forward, indices=sources))

    def turn_ms(self, node: int, to_node: Costs) -> int:
        """Cost of the shortest cycle through a node, given the costs to it, (nodes,)."""
        return min(
            (cost + int(to_node[target]) for target, cost, _ in self._product.edges(node)),
            default=FAR,
        )

    def walk(self, start: int, goal: int, to_goal: Costs) -> list[Stride]:
        """The shortest way from a node to another; the shortest cycle if they are the same.

        Args:
            to_goal: cost from every node to the goal, (nodes,).
        """
        strides: list[Stride] = []
        node = start
        while not strides or node != goal:
            node, cost, action = min(
                self._product.edges(node), key=lambda edge: (edge[1] + to_goal[edge[0]], edge[2])
            )
            strides.append(Stride(action, cost, node))
        return strides

    def arrival(self, node: int) -> list[Stride]:
        """The shortest way from the start to a node or a twin of it."""
        twins = np.flatnonzero(self.twins == self.twins[node])
        goal = int(twins[self._raw_arrivals[twins].argmin()])
        (to_goal,) = self.to([goal])
        root = min(self._product.roots, key=to_goal.__getitem__)
        return self.walk(root, goal, to_goal) if root != goal else []


def _whole(costs: np.ndarray) -> Costs:
    """Costs as integers; no way is FAR."""
    return np.where(np.isinf(costs), FAR, costs).astype(np.int64)
