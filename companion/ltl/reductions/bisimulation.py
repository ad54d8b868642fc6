"""Bisimulation: finds nodes that behave alike in all steps, by refining a partition.

Nodes of one colour begin as one block. A block is split as long as its nodes read different
letters, or meet different marks, on the way into some block.

Source: Moore, Gedanken-experiments on sequential machines, 1956, for deterministic automata;
Kanellakis and Smolka, CCS expressions, finite state processes, and three problems of equivalence,
Information and Computation 1990, for others.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence

from companion.ltl.budget import Budget
from companion.ltl.graph import LabelledEdge, Marks, Nodes
from companion.ltl.labels import LetterSet

Arrows = Sequence[Sequence[LabelledEdge[LetterSet]]]
"""The edges that leave each node; or those that enter it, with their sources as targets."""

Signature = dict[tuple[Marks, int], LetterSet]
"""For certain marks and a certain block of nodes, the letters of the edges to (or from) it."""


def bisimilar(arrows: Arrows, colours: Sequence[int], budget: Budget) -> list[Nodes]:
    """For each node, the nodes that have its colour and behave alike in all steps.

    Raises:
        TranslationLimit: the budget is spent.
    """
    block, count = list(colours), len(set(colours))
    size = sum(map(len, arrows))
    while True:
        budget.spend(3 * (size + len(arrows)))
        number_of: dict[Hashable, int] = {}
        block = [
            number_of.setdefault(
                (block[node], frozenset(signature(leaving, block).items())), len(number_of)
            )
            for node, leaving in enumerate(arrows)
        ]
        if len(number_of) == count:
            break
        count = len(number_of)
    nodes_of = [0] * count
    for node, number in enumerate(block):
        nodes_of[number] |= 1 << node
    return [nodes_of[number] for number in block]


def signature(leaving: Iterable[LabelledEdge[LetterSet]], block: Sequence[int]) -> Signature:
    """The letters of the edges with the same marks to the same block."""
    found: Signature = {}
    for label, marks, target in leaving:
        kind = (marks, block[target])
        if kind in found:
            found[kind] |= label
        else:
            found[kind] = label
    return found


def redirected(
    leaving: Iterable[LabelledEdge[LetterSet]], block: Sequence[int]
) -> list[LabelledEdge[LetterSet]]:
    """One edge in place of all with the same marks to the same block, which is its target."""
    return [LabelledEdge(letters, *kind) for kind, letters in signature(leaving, block).items()]
