"""Intersection: the product of two graphs accepts the words that both of them accept.

A language that no finite prefix belongs to, as that of G F a, may be read from any position on. So
its graph need not run where the other one cannot accept: it is *suspended* there, and starts where
a component is entered in which the other one can.

Source: Babiak, Badie, Duret-Lutz, Křetínský and Strejček, Compositional approach to suspension and
other improvements to LTL translation, SPIN 2013, for suspension.
"""

from __future__ import annotations

from collections.abc import Iterator

from companion.ltl.budget import Budget
from companion.ltl.graph import LabelledEdge, LabelledGraph, Marks, accepting_nodes, product
from companion.ltl.labels import LetterSet

_SUSPENDED = -1
"""Stands for the node of a graph that does not run."""


def intersection(
    one: LabelledGraph[LetterSet],
    other: LabelledGraph[LetterSet],
    budget: Budget,
    *,
    suspending: bool = False,
) -> LabelledGraph[LetterSet]:
    """The words that both graphs accept; the marks of the second come after those of the first.

    Args:
        suspending: whether the second is suspended where the first cannot accept; whether it
            accepts a word must not depend on any finite prefix.

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
