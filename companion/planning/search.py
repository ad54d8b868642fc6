"""Finds the best lasso of a problem: the shortest lap, and to it the shortest prefix.

A mission that loops for ever pays the lap for ever, so the objective is lexicographic. The sum
of prefix and lap, which a classical planner minimises on the paper's compilation (Figs. 2-4),
takes a lap of 80 on the paper's mission where one of 68 exists.

A loop is a cycle of the product that meets every mark. It passes an edge with the rarest mark,
so it is enough to search from the sources of those edges (the anchors): Dijkstra's algorithm
over (node, marks met so far). Equal costs fall to the order of the mission file.

The lap is optimal; the prefix is optimal for the laps found, one per anchor.
"""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Iterable

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from companion.planning.lasso import Lasso, Problem
from companion.planning.product import Edge, Product

Path = tuple[int, ...]
"""Indices of actions, or of the nodes that they join."""


def find_lasso(problem: Problem) -> Lasso | None:
    """The best lasso, or None if the task cannot be done from here.

    Raises:
        SearchLimit: the product has too many states to search.
    """
    product = Product(problem)
    laps = _shortest_laps(product)
    if not laps:
        return None
    arrivals = _shortest_paths(product, product.roots)
    lap = min(lap.cost_ms for lap in laps)
    _, prefix, suffix = min(
        (arrivals[node][0], arrivals[node][1], lap_from)
        for candidate in laps
        if candidate.cost_ms == lap
        for node, lap_from in candidate.rotations()
    )
    actions = problem.actions
    return Lasso(tuple(actions[i] for i in prefix), tuple(actions[i] for i in suffix))


class _Lap:
    """A cycle: its cost, its actions, and the nodes that they leave."""

    def __init__(self, cost_ms: int, path: Path, nodes: tuple[int, ...]) -> None:
        self.cost_ms = cost_ms
        self._path = path
        self._nodes = nodes

    def rotations(self) -> Iterable[tuple[int, Path]]:
        """Each node at which the loop may be entered, with the loop's actions from there."""
        for i, node in enumerate(self._nodes):
            yield node, self._path[i:] + self._path[:i]


def _shortest_laps(product: Product) -> list[_Lap]:
    """The shortest accepting cycle through each anchor that can have the shortest of all."""
    laps: list[_Lap] = []
    bound: int | None = None
    for inner in _accepting_components(product):
        for anchor in _anchors(product, inner):
            lap = _shortest_lap(product, inner, anchor, bound)
            if lap is not None:
                laps.append(lap)
                bound = lap.cost_ms if bound is None else min(bound, lap.cost_ms)
    return laps


def _accepting_components(product: Product) -> list[dict[int, list[Edge]]]:
    """The inner edges, by source, of each strong component that meets every mark."""
    sources = [node for node, edges in enumerate(product.edges) for _ in edges]
    targets = [edge.target for edges in product.edges for edge in edges]
    size = len(product.edges)
    graph = csr_array((np.ones(len(sources), np.int8), (sources, targets)), shape=(size, size))
    count, component = connected_components(graph, connection="strong")
    inner: list[dict[int, list[Edge]]] = [{} for _ in range(count)]
    for node, edges in enumerate(product.edges):
        kept = [edge for edge in edges if component[edge.target] == component[node]]
        if kept:
            inner[component[node]][node] = kept
    return [c for c in inner if c and _union(c) == product.all_marks]


def _union(component: dict[int, list[Edge]]) -> int:
    marks = 0
    for edges in component.values():
        for edge in edges:
            marks |= edge.marks
    return marks


def _anchors(product: Product, inner: dict[int, list[Edge]]) -> list[int]:
    """Nodes of which every accepting cycle of a component passes at least one."""
    if not product.all_marks:
        return sorted(inner)
    sources: Counter[int] = Counter()
    for edges in inner.values():
        marks = 0
        for edge in edges:
            marks |= edge.marks
        sources.update(m for m in range(product.all_marks.bit_length()) if marks >> m & 1)
    rarest = min(sources, key=lambda m: (sources[m], m))
    return sorted(n for n, edges in inner.items() if any(e.marks >> rarest & 1 for e in edges))


def _shortest_lap(
    product: Product, inner: dict[int, list[Edge]], anchor: int, bound: int | None
) -> _Lap | None:
    """The shortest cycle from an anchor that meets every mark, unless it is above the bound."""
    queue: list[tuple[int, Path, Path, int]] = [(0, (), (anchor,), 0)]
    settled: set[tuple[int, int]] = set()
    while queue:
        cost, path, nodes, met = heapq.heappop(queue)
        if path:
            if nodes[-1] == anchor and met == product.all_marks:
                return _Lap(cost, path, nodes[:-1])
            if (nodes[-1], met) in settled:
                continue
            settled.add((nodes[-1], met))
        for edge in inner.get(nodes[-1], ()):
            now_met = met | edge.marks
            total = cost + edge.cost_ms
            if (edge.target, now_met) not in settled and (bound is None or total <= bound):
                step = (total, (*path, edge.action), (*nodes, edge.target), now_met)
                heapq.heappush(queue, step)
    return None


def _shortest_paths(product: Product, roots: list[int]) -> dict[int, tuple[int, Path]]:
    """Cost and actions of the shortest path from a root to every reachable node."""
    found: dict[int, tuple[int, Path]] = {}
    queue: list[tuple[int, Path, int]] = [(0, (), root) for root in roots]
    while queue:
        cost, path, node = heapq.heappop(queue)
        if node in found:
            continue
        found[node] = (cost, path)
        for edge in product.edges[node]:
            if edge.target not in found:
                heapq.heappush(queue, (cost + edge.cost_ms, (*path, edge.action), edge.target))
    return found
