"""Recurrence: makes an automaton of G F a from one of F a, if a finite prefix can show `a`.

An automaton of F a accepts by reaching one state, in which `a` has been seen. An automaton of G F a
starts again instead of reaching that state, on an edge with a mark. It starts at the initial state,
or, because the last letter may be the first of the next `a`, where that letter leads from there.

A deterministic automaton of F a remembers every possible beginning of an `a`. No prefix matters to
G F a, so all its states accept the same words, and any may be initial. An automaton that guesses
where `a` begins is often smaller: 4 states for G F(a & X X X b) instead of 8.

Source: Esparza, Křetínský and Sickert, One theorem to rule them all: a unified translation of LTL
into omega-automata, LICS 2018, for the automaton of G F a.
"""

from __future__ import annotations

from functools import reduce
from operator import or_

from companion.ltl.components import strong_components
from companion.ltl.formula import FALSE, TRUE, Formula, Operator, subformulas
from companion.ltl.graph import (
    LabelledEdge,
    LabelledGraph,
    accepting_nodes,
    is_deterministic,
    reachable,
)
from companion.ltl.labels import LetterSet


def is_recurrence(formula: Formula) -> bool:
    """Whether a formula in negation normal form is G F a with no R in `a`."""
    if formula.operator is not Operator.RELEASE or formula.operands[0] is not FALSE:
        return False
    inner = formula.operands[1]
    return (
        inner.operator is Operator.UNTIL
        and inner.operands[0] is TRUE
        and not any(node.operator is Operator.RELEASE for node in subformulas(inner))
    )


def restarted(
    graph: LabelledGraph[LetterSet], every: LetterSet, overlapping: bool
) -> LabelledGraph[LetterSet] | None:
    """A graph of G F a, given one of F a.

    Args:
        every: the set of all letters.
        overlapping: whether the last letter of an `a` can be the first of the next.

    Returns:
        None if the graph does not accept by reaching a single node that accepts every word.
    """
    end = _end(graph, every)
    if end is None or end == 0:
        return None
    again = graph.edges[0] if overlapping else [LabelledEdge(every, 0, 0)]
    edges: list[list[LabelledEdge[LetterSet]]] = []
    for leaving in graph.edges:
        edges.append([edge._replace(marks=0) for edge in leaving if edge.target != end])
        for last in [edge for edge in leaving if edge.target == end]:
            for first in again:
                if letters := last.label & first.label:
                    target = 0 if first.target == end else first.target
                    edges[-1].append(LabelledEdge(letters, 1, target))
    edges[end] = []
    if not is_deterministic(graph):
        return reachable(edges, 1)
    components = strong_components([[edge.target for edge in leaving] for leaving in edges])
    return reachable(edges, 1, next(nodes[0] for nodes in components if edges[nodes[0]]))


def _end(graph: LabelledGraph[LetterSet], every: LetterSet) -> int | None:
    """The only node in which an accepting run may stay, if it reads all letters there."""
    accepting = accepting_nodes(graph)
    if len(accepting) != 1:
        return None
    (end,) = accepting
    read = [edge.label for edge in graph.edges[end] if edge.target == end]
    return end if reduce(or_, read) == every else None
