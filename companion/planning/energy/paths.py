"""Paths of least time, or of least energy, along some edges of a graph.

Ties go to the path of least energy, or of least time. Time and energy are packed into one number,
with the minimised one in the upper bits.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from companion.planning.builtin.costs import UNREACHABLE_MS, Costs
from companion.planning.effort import DIJKSTRA_STEP_US
from companion.planning.energy.sorties import PathTable, Units
from companion.slices import spent

_TIME_BITS, _DRAIN_BITS = 30, 22
"""A path takes less than 2^30 ms and 2^22 units; both together fit exactly into a float."""
_STEPS_OF_NODE = 30


class Paths:
    """The paths from some nodes.

    Args:
        nodes: number of nodes.
        edges: start, end and number of each edge.
        costs: time and energy of each edge.
        starts: where paths begin.
        is_thrifty: whether to minimise the energy instead of the time.
    """

    def __init__(
        self,
        nodes: int,
        edges: tuple[NDArray[np.intp], NDArray[np.int32], NDArray[np.intp]],
        costs: tuple[Costs, Units],
        starts: list[int],
        is_thrifty: bool,
    ) -> None:
        times, drains = costs
        self._starts, self._is_thrifty = starts, is_thrifty
        self._bits = _TIME_BITS if is_thrifty else _DRAIN_BITS
        weights = (drains << _TIME_BITS) + times if is_thrifty else (times << _DRAIN_BITS) + drains
        begins, ends, numbers, weights = _least((*edges, weights))
        matrix = csr_array((weights.astype(float), (begins, ends)), shape=(nodes, nodes))
        spent(DIJKSTRA_STEP_US * (len(numbers) + _STEPS_OF_NODE * nodes) * len(starts))
        self._costs, self._before = dijkstra(matrix, indices=starts, return_predecessors=True)
        self._number_of = {
            (int(a), int(b)): int(n) for a, b, n in zip(begins, ends, numbers, strict=True)
        }

    def table(self, ends: list[int]) -> PathTable:
        """The paths from each start to some nodes; the path from a node to itself is empty."""
        costs = self._costs[:, ends]
        is_open = np.isfinite(costs)
        whole = np.where(is_open, costs, 0).astype(np.int64)
        upper, lower = whole >> self._bits, whole & (1 << self._bits) - 1
        times, drains = (lower, upper) if self._is_thrifty else (upper, lower)
        return PathTable(np.where(is_open, times, UNREACHABLE_MS), drains)

    def path(self, start: int, end: int) -> list[int]:
        """The edges of the path to a node, from a start given by its index."""
        begin = self._starts[start]
        nodes = [end]
        while nodes[-1] != begin:
            nodes.append(int(self._before[start, nodes[-1]]))
        return [self._number_of[pair] for pair in pairwise(nodes[::-1])]


def _least(edges: tuple[NDArray[Any], ...]) -> tuple[NDArray[Any], ...]:
    """From edges with start, end, number and weight: the one of least weight for each pair."""
    begins, ends, _, weights = edges
    order = np.lexsort((weights, ends, begins))
    pairs = np.stack((begins, ends))[:, order]
    is_new = np.append(True, (np.diff(pairs) != 0).any(axis=0))[: len(order)]
    return tuple(each[order][is_new] for each in edges)
