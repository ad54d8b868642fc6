"""Intersection: the product of two graphs accepts the words that both of them accept."""

from __future__ import annotations

from collections import defaultdict

from companion.ltl.budget import Budget
from companion.ltl.graph import LabelledEdge, LabelledGraph, Marks
from companion.ltl.labels import LetterSet


def intersection(
    one: LabelledGraph[LetterSet], other: LabelledGraph[LetterSet], budget: Budget
) -> LabelledGraph[LetterSet]:
    """The words that both graphs accept; the marks of the second come after those of the first.

    Raises:
        TranslationLimit: the budget is spent.
    """
    width = max((e.label.bit_length() for leaving in one.edges for e in leaving), default=0)
    number_of = {(0, 0): 0}
    pending = [(0, 0)]
    edges: list[list[LabelledEdge[LetterSet]]] = []
    for first, second in pending:  # grows while it is read
        budget.spend(5 * len(one.edges[first]) * len(other.edges[second]), width)
        joint: dict[tuple[Marks, int], LetterSet] = defaultdict(LetterSet)
        for label, marks, target in one.edges[first]:
            for also, more, partner in other.edges[second]:
                if label & also:
                    number = number_of.setdefault((target, partner), len(pending))
                    if number == len(pending):
                        pending.append((target, partner))
                    joint[marks | more << one.marks, number] |= label & also
        budget.keep(len(joint), width)
        edges.append([LabelledEdge(letters, *kind) for kind, letters in joint.items()])
    return LabelledGraph(edges, one.marks + other.marks)
