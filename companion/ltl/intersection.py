"""Intersection: the product of two graphs accepts the words that both of them accept.

A language that no finite prefix belongs to, as that of G F a, may be read from any position on. So
its graph need not run where the other one cannot accept: it is *suspended* there, and starts where
a component is entered in which the other one can.

Source: Babiak, Badie, Duret-Lutz, Křetínský and Strejček, Compositional approach to suspension and
other improvements to LTL translation, SPIN 2013, for suspension.
"""

from __future__ import annotations

from collections import defaultdict

from companion.ltl.budget import Budget
from companion.ltl.graph import LabelledEdge, LabelledGraph, Marks, accepting_nodes
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
    start = (0, 0 if 0 in running else _SUSPENDED)
    number_of = {start: 0}
    pending = [start]
    edges: list[list[LabelledEdge[LetterSet]]] = []
    idle = [LabelledEdge(~LetterSet(0), 0, 0)]
    for first, second in pending:  # grows while it is read
        beside = idle if second == _SUSPENDED else other.edges[second]
        budget.spend(5 * len(one.edges[first]) * len(beside), width)
        joint: dict[tuple[Marks, int], LetterSet] = defaultdict(LetterSet)
        for label, marks, target in one.edges[first]:
            for also, more, partner in beside if target in running else idle:
                if label & also:
                    pair = (target, partner if target in running else _SUSPENDED)
                    number = number_of.setdefault(pair, len(pending))
                    if number == len(pending):
                        pending.append(pair)
                    joint[marks | more << one.marks, number] |= label & also
        budget.keep(len(joint), width)
        edges.append([LabelledEdge(letters, *kind) for kind, letters in joint.items()])
    return LabelledGraph(edges, one.marks + other.marks)
