"""Recurrence: an automaton of G F a from one of F a, for an `a` that some finite prefix shows.

The smallest deterministic automaton of F a has one state in which `a` has been seen. An automaton
of G F a starts again where that state would be reached, with a mark: at its initial state, or,
since the last letter may be the first of the next `a`, where that letter leads from there. What
G F a says does not depend on any prefix, so every state accepts it, and may be initial.

Source: Esparza, Křetínský and Sickert, One theorem to rule them all: a unified translation of LTL
into omega-automata, LICS 2018, for the automaton of G F a.
"""

from __future__ import annotations

from companion.ltl.components import strong_components
from companion.ltl.formula import FALSE, TRUE, Formula, Operator, subformulas
from companion.ltl.graph import LabelledEdge, LabelledGraph, reachable
from companion.ltl.labels import LetterSet


def is_recurrence(formula: Formula) -> bool:
    """Whether a formula in negation normal form is G F a, and `a` has no R."""
    if formula.operator is not Operator.RELEASE or formula.operands[0] is not FALSE:
        return False
    inner = formula.operands[1]
    return (
        inner.operator is Operator.UNTIL
        and inner.operands[0] is TRUE
        and not any(node.operator is Operator.RELEASE for node in subformulas(inner))
    )


def restarted(weak: LabelledGraph[LetterSet], overlapping: bool) -> LabelledGraph[LetterSet]:
    """A graph of G F a, given the smallest weak deterministic one of F a.

    Args:
        overlapping: whether the last letter of an `a` counts as the first of the next.
    """
    (end,) = (n for n, leaving in enumerate(weak.edges) if all(e.target == n for e in leaving))
    again = weak.edges[0] if overlapping else [LabelledEdge(~LetterSet(0), 0, 0)]
    edges: list[list[LabelledEdge[LetterSet]]] = []
    for leaving in weak.edges:
        edges.append([edge._replace(marks=0) for edge in leaving if edge.target != end])
        for last in [edge for edge in leaving if edge.target == end]:
            for first in again:
                if letters := last.label & first.label:
                    target = 0 if first.target == end else first.target
                    edges[-1].append(LabelledEdge(letters, 1, target))
    edges[end] = []
    components = strong_components([[edge.target for edge in leaving] for leaving in edges])
    return reachable(edges, 1, next(nodes[0] for nodes in components if edges[nodes[0]]))
