"""Intersection: the product of two graphs accepts the words that both of them accept.

If no finite prefix matters to a language, as with G F a, it may be read from any position on. Its
graph need not run while the other one cannot accept: it is *suspended*, and starts when the other
graph enters a component in which it can accept.

Source: Babiak, Badie, Duret-Lutz, Křetínský and Strejček, Compositional approach to suspension and
other improvements to LTL translation, SPIN 2013, for suspension.
"""

from __future__ import annotations

from collections.abc import Iterator

from companion.ltl.budget import Budget
from companion.ltl.graph import LabelledEdge, LabelledGraph, Marks, accepting_nodes, product
from companion.ltl.labels import LetterSet

_SUSPENDED = -1
"""Replaces the node of a graph that is suspended."""


def intersection(
    one: LabelledGraph[LetterSet],
    other: LabelledGraph[LetterSet],
    budget: Budget,
    *,
    suspending: bool = False,
) -> LabelledGraph[LetterSet]:
    """A graph of the words that both accept; the second graph's marks come after the first's.

    Args:
        suspending: whether the second is suspended while the first cannot accept; allowed only if
            no finite prefix decides whether the second accepts a word.

    Raises:
        TranslationLimit: the budget is spent.
    """
    width = max((e.label.bit_length() for leaving in one.edges for e in leaving), default=0)
    running = accepting_nodes(one) if suspending else set(range(len(one.edges)))
    idle = [LabelledEdge(~LetterSet(0), 0, 0)]

    def leaving(pair: tuple[int, int]) -> Iterator[tuple[LetterSet, Marks, tuple[int, int]]]:
        first, second = pair
        beside = idle if second == _SUSPENDED else other.edges[second]
        budget.spend(5 * len(one.edges[first]) * len(beside), width)
        for label, marks, target in one.edges[first]:
            for also, more, partner in beside if target in running else idle:
                if letters := label & also:
                    after = partner if target in running else _SUSPENDED
                    yield letters, marks | more << one.marks, (target, after)

    start = (0, 0 if 0 in running else _SUSPENDED)
    return product(start, leaving, one.marks + other.marks, budget, width)
