"""The shortest round by definition: over all orders of all choices of hits."""

from __future__ import annotations

import itertools
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from companion.planning.builtin.rounds import FAR, Costs

Marks = NDArray[np.bool_]


def shortest(legs: Costs) -> Costs:
    """The costs of shortest ways with at least one step."""
    ways = legs.copy()
    for via in range(len(ways)):
        ways = np.minimum(ways, ways[:, via, None] + ways[via])
    return ways


def best_round(between: Costs, marks: Marks, passing: int | None = None) -> int:
    """Over every order of every choice of hits; `passing` is one that has to be there."""
    best = FAR
    for size in range(1, len(between) + 1):
        for order in itertools.permutations(range(len(between)), size):
            if marks[list(order)].any(axis=0).all() and passing in (None, *order):
                best = min(best, cost_of(between, order))
    return best


def cost_of(between: Costs, order: Iterable[int]) -> int:
    """Of a closed walk; a hit may come twice in a row."""
    walked = [hit for hit, _ in itertools.groupby(order)]
    if len(walked) > 1 and walked[0] == walked[-1]:
        walked.pop()
    return int(sum(between[a, b] for a, b in itertools.pairwise([*walked, walked[0]])))


def ways_of(between: Costs) -> tuple[Costs, Costs]:
    """From each node to each hit and back, where the hits are all nodes there are."""
    ways = between.copy()
    np.fill_diagonal(ways, 0)
    return ways.T.copy(), ways
