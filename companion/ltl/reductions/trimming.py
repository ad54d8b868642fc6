"""Trimming: drops states that accept nothing, and acceptance marks that are redundant.

Whether a mark is redundant depends on its strongly connected component, as every run finally stays
in one.

Source: Somenzi and Bloem, Efficient Büchi automata from LTL formulae, CAV 2000.
"""

from __future__ import annotations

from enum import Enum, auto
from functools import reduce
from operator import or_

from companion.ltl.bitsets import minimal
from companion.ltl.components import acyclic, reaching, strong_components
from companion.ltl.graph import LabelledEdge, LabelledGraph, Marks, reachable
from companion.ltl.labels import L


class Departures(Enum):
    """Which marks edges between components get; the language does not depend on them."""

    UNMARKED = auto()
    AS_GIVEN = auto()
    MARKED = auto()


def trimmed(
    graph: LabelledGraph[L], departures: Departures = Departures.UNMARKED
) -> LabelledGraph[L]:
    """The graph without nodes that accept nothing and without redundant marks.

    Within a component a mark is redundant if every edge has it, or if another mark only occurs
    together with it. A component with loops that cannot accept keeps no marks.

    Args:
        departures: which marks edges between components have: none; those that matter in the
            component that they enter; or all, if the component that they leave can accept.
    """
    every_mark = (1 << graph.marks) - 1
    successors = graph.successors
    components = strong_components(successors)
    component_of: dict[int, int] = {}
    essential: list[list[Marks] | None] = []  # for each component; None if it cannot accept
    accepting: list[bool] = []
    for number, component in enumerate(components):
        component_of.update(dict.fromkeys(component, number))
        leaving = [edge for node in component for edge in graph.edges[node]]
        inside = [e.marks for e in leaving if component_of.get(e.target) == number]
        accepting.append(bool(inside) and reduce(or_, inside) == every_mark)
        only_rejects = bool(inside) and not accepting[-1]
        essential.append(None if only_rejects else essential_marks(inside, graph.marks))
    alive = reaching(successors, components, accepting)
    marks = max(1 if kept is None else len(kept) for kept in essential)

    def marks_of(edge: LabelledEdge[L], component: int) -> Marks:
        after = component_of[edge.target]
        if after != component and departures is not Departures.AS_GIVEN:
            is_marked = departures is Departures.MARKED and accepting[component]
            return (1 << marks) - 1 if is_marked else 0
        kept = essential[after]
        if kept is None:
            return 0
        unneeded = (1 << marks) - (1 << len(kept))  # a mark on every edge is redundant
        return unneeded | sum([1 << i for i, mark in enumerate(kept) if edge.marks & mark])

    edges = [
        [
            LabelledEdge(edge.label, marks_of(edge, component_of[node]), edge.target)
            for edge in leaving
            if edge.target in alive
        ]
        for node, leaving in enumerate(graph.edges)
    ]
    return reachable(edges, marks)


def essential_marks(inside: list[Marks], marks: int) -> list[Marks]:
    """The marks (each as a set of one) that matter in a component, given the marks of its edges.

    >>> [bin(mark) for mark in essential_marks([0b011, 0b111, 0b010], 3)]
    ['0b100']
    """
    kinds = sorted(set(inside))
    where = {
        sum(1 << i for i, kind in enumerate(kinds) if kind >> mark & 1): 1 << mark
        for mark in reversed(range(marks))
    }
    everywhere = (1 << len(kinds)) - 1
    return sorted(where[places] for places in minimal(where) if places != everywhere)


def trimmed_by_states(graph: LabelledGraph[L], transient_marked: bool) -> LabelledGraph[L]:
    """The trimmed graph, where one mark is on all edges of accepting nodes and on no others.

    Nodes that accept nothing are dropped. As many of the others as possible become accepting,
    because fewer kinds of nodes can be merged better: a node also becomes accepting if it is on no
    cycle of rejecting nodes.

    Args:
        transient_marked: whether nodes on no cycle accept; the language does not depend on it.
    """
    marked = {node for node, leaving in enumerate(graph.edges) if leaving and leaving[0].marks}
    successors = graph.successors
    components = strong_components(successors)
    accepting: list[bool] = []
    for component in components:
        own = set(component)
        inside = {n: [t for t in successors[n] if t in own] for n in component}
        accepting.append(any(inside.values()) and not own.isdisjoint(marked))
        if not any(inside.values()):
            (marked.update if transient_marked else marked.difference_update)(own)
        elif accepting[-1]:
            marked |= acyclic({n: inside[n] for n in component if n not in marked})
    alive = reaching(successors, components, accepting)
    edges = [
        [LabelledEdge(e.label, int(node in marked), e.target) for e in leaving if e.target in alive]
        for node, leaving in enumerate(graph.edges)
    ]
    return reachable(edges, 1)
