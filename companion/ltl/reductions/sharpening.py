"""Sharpening: makes cubes disjoint if one more literal is enough for that.

If two edges of a node read the same letter and one edge is better, the other need not read that
letter. Then a word has fewer runs, and nodes often become unreachable. Sets of letters lose such
letters in every quotient (`quotient.py`).
"""

from __future__ import annotations

from companion.ltl.budget import Budget
from companion.ltl.graph import LabelledEdge, LabelledGraph
from companion.ltl.labels import Cube, opposite
from companion.ltl.reductions.simulation import cube_simulators


def sharpened(graph: LabelledGraph[Cube], budget: Budget) -> LabelledGraph[Cube]:
    """A graph whose labels exclude the letters of better edges, if one more literal can do that.

    Raises:
        TranslationLimit: the budget is spent.
    """
    simulators = cube_simulators(graph, budget)
    budget.spend(2 * sum(len(leaving) ** 2 for leaving in graph.edges))

    def is_better(one: LabelledEdge[Cube], other: LabelledEdge[Cube]) -> bool:
        """Whether every run that takes the second edge can take the first instead."""
        has_marks = one.marks & other.marks == other.marks
        return has_marks and bool(simulators[other.target] >> one.target & 1)

    edges = []
    for leaving in graph.edges:
        sharp = list(leaving)
        for i, edge in enumerate(sharp):
            for better in sharp[:i] + sharp[i + 1 :]:
                excess = better.label & ~sharp[i].label
                if int(excess).bit_count() == 1 and is_better(better, edge):
                    sharp[i] = sharp[i]._replace(label=sharp[i].label | opposite(excess))
        edges.append(sharp)
    return LabelledGraph(edges, graph.marks)
