"""The shortest tour by definition: over all orders of all choices of targets."""

from __future__ import annotations

import itertools
from collections.abc import Iterable

import numpy as np

from companion.planning.builtin.costs import UNREACHABLE_MS, Costs, Marks


def shortest(legs: Costs) -> Costs:
    """The costs of shortest paths with at least one edge."""
    costs = legs.copy()
    for via in range(len(costs)):
        costs = np.minimum(costs, costs[:, via, None] + costs[via])
    return costs


def best_tour(between: Costs, marks: Marks, passing: int | None = None) -> int:
    """Over every order of every choice of targets; `passing` is one that has to be there."""
    best = UNREACHABLE_MS
    for size in range(1, len(between) + 1):
        for order in itertools.permutations(range(len(between)), size):
            if marks[list(order)].any(axis=0).all() and passing in (None, *order):
                best = min(best, cost_of(between, order))
    return best


def cost_of(between: Costs, order: Iterable[int]) -> int:
    """Of a closed walk; a target may come twice in a row."""
    walked = [target for target, _ in itertools.groupby(order)]
    if len(walked) > 1 and walked[0] == walked[-1]:
        walked.pop()
    return int(sum(between[a, b] for a, b in itertools.pairwise([*walked, walked[0]])))


def costs_of(between: Costs) -> tuple[Costs, Costs]:
    """From each node to each target and back, where the targets are all nodes there are."""
    costs = between.copy()
    np.fill_diagonal(costs, 0)
    return costs.T.copy(), costs
