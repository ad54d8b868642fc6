"""Bisimulation: which nodes do the same in all steps, by refinement of a partition.

Nodes of one colour are a block; a block is split while its nodes read different letters, or with
different marks, into some block.

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
"""The edges that leave each node, or those that enter it with their sources as targets."""

Signature = dict[tuple[Marks, int], LetterSet]
"""The letters of the edges with certain marks to (or from) a certain block of nodes."""


def bisimilar(arrows: Arrows, colours: Sequence[int], budget: Budget) -> list[Nodes]:
    """For each node the nodes that have its colour and do the same in all steps.

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
    """The letters of edges with the same marks to the same block."""
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
    """One edge for all with the same marks to the same block, which becomes the target."""
    return [LabelledEdge(letters, *kind) for kind, letters in signature(leaving, block).items()]
