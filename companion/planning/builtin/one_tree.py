"""The 1-tree bound: no tour over some nodes is shorter than their heaviest minimum 1-tree.

A 1-tree is a spanning tree of all nodes except one, plus two edges of that one. Prices on the nodes
change the weights of 1-trees, but the cost of every tour by the same amount. So subgradient ascent
on the prices raises the bound.

Source: Held and Karp, The traveling-salesman problem and minimum spanning trees, 1970.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import minimum_spanning_tree

from companion.planning.builtin.costs import UNREACHABLE_MS, Costs, Marks
from companion.slices import spent

MAX_ASCENTS = 150
_ASCENT_US = 150.0


def lower_bound_ms(between: Costs, marks: Marks, upper_ms: int) -> int:
    """A lower bound for the cost of all tours that meet every mark.

    A tour passes a target of every mark. So it is at least as long as a tour over the marks, with
    the least distance between their targets, in either direction.

    Args:
        between: cost of the shortest path from target to target, (T, T).
        marks: marks of the targets, (T, M).
        upper_ms: cost of a known tour.

    >>> between = np.array([[9, 1, 4], [1, 9, 2], [4, 2, 9]])
    >>> lower_bound_ms(between, np.eye(3, dtype=np.bool_), 7)
    7
    """
    groups = [np.flatnonzero(column) for column in marks.T]
    nearest = np.array([between[group].min(axis=0) for group in groups])
    least = np.array([nearest[:, group].min(axis=1) for group in groups])
    least[marks.T.astype(int) @ marks > 0] = 0  # one target has both marks
    least = np.minimum(least, least.T)
    unit = int(np.gcd.reduce(between[between < UNREACHABLE_MS]))
    bound = _heaviest(least.astype(float), upper_ms)
    return unit * int(np.ceil((bound - 1e-6) / unit))


def _heaviest(costs: NDArray[np.float64], upper: float) -> float:
    """The greatest weight of a minimum 1-tree that the ascent finds."""
    size = len(costs)
    if size < 3:
        return float(2 * costs[0, 1]) if size == 2 else 0.0
    prices = np.zeros(size)
    best, step = 0.0, 1.0
    for _ in range(MAX_ASCENTS):
        spent(_ASCENT_US)
        priced = costs + prices[:, None] + prices
        weight, degrees = _minimum(priced)
        bound = weight - 2 * prices.sum()
        best = max(best, bound)
        slope = degrees - 2
        steepness = float(slope @ slope)
        if not steepness or best >= upper:
            break
        prices += step * max(upper - bound, 1.0) / steepness * slope
        step *= 0.97
    return best


def _minimum(priced: NDArray[np.float64]) -> tuple[float, NDArray[np.int64]]:
    """Weight and node degrees of the minimum 1-tree; the first node is the one outside the tree."""
    size = len(priced)
    shift = 1.0 - priced.min()  # scipy treats a zero weight as a missing edge
    tree = minimum_spanning_tree(priced[1:, 1:] + shift).tocoo()
    ends = np.argsort(priced[0, 1:], kind="stable")[:2] + 1
    degrees = np.bincount(np.concatenate([tree.row, tree.col]) + 1, minlength=size)
    degrees[0] = 2
    degrees[ends] += 1
    weight = float(tree.data.sum()) - shift * (size - 2) + float(priced[0, ends].sum())
    return weight, degrees
