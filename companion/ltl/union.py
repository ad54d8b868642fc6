"""Union: the product of two graphs accepts the words that at least one of them accepts.

The first graph is weak and deterministic. Its one run is followed together with those of the
second, and shows whether the first accepts: while it does, all marks are met, otherwise those of
the second. So no choice is guessed, unlike in a new initial node with the edges of both.
"""

from __future__ import annotations

from collections.abc import Iterator

from companion.ltl.budget import Budget
from companion.ltl.graph import LabelledEdge, LabelledGraph, Marks, accepting_nodes, product
from companion.ltl.labels import LetterSet

_DEAD = -1
"""Replaces the node of a graph that accepts nothing any more."""

_SUSPENDED = -2
"""Replaces the node of a graph that is suspended."""


def union(
    weak: LabelledGraph[LetterSet],
    other: LabelledGraph[LetterSet],
    every: LetterSet,
    budget: Budget,
    *,
    suspending: bool = False,
) -> LabelledGraph[LetterSet]:
    """A graph of the words that one of two graphs accepts, with the marks of the second.

    Args:
        weak: deterministic; either all cycles of a component accept, or none does.
        other: has at least one mark.
        every: the set of all letters.
        suspending: whether the second is suspended while the first accepts; allowed only if no
            finite prefix decides whether the second accepts a word.

    Raises:
        TranslationLimit: the budget is spent.
    """
    width = every.bit_length()
    every_mark = (1 << other.marks) - 1
    accepting = accepting_nodes(weak)
    idle = [LabelledEdge(every, 0, 0)]
    halted = accepting if suspending else set[int]()

    def leaving(pair: tuple[int, int]) -> Iterator[tuple[LetterSet, Marks, tuple[int, int]]]:
        first, second = pair
        ways = _completed(weak, first, every)
        beside = idle if second == _SUSPENDED else _completed(other, second, every)
        budget.spend(5 * len(ways) * len(beside), width)
        for label, _, target in ways:
            for also, met, partner in beside:
                after = (target, _SUSPENDED if target in halted else partner)
                if (letters := label & also) and after != (_DEAD, _DEAD):
                    yield letters, every_mark if first in accepting else met, after

    return product((0, _SUSPENDED if 0 in halted else 0), leaving, other.marks, budget, width)


def _completed(
    graph: LabelledGraph[LetterSet], node: int, every: LetterSet
) -> list[LabelledEdge[LetterSet]]:
    """The edges of a node, and one to the dead node for the letters that no other edge reads."""
    leaving = [] if node == _DEAD else graph.edges[node]
    missing = every
    for label, _, _ in leaving:
        missing &= ~label
    return [*leaving, LabelledEdge(missing, 0, _DEAD)] if missing else leaving
