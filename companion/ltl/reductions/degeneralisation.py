"""Degeneralisation: makes one acceptance set of states from several sets of edges.

Within a strongly connected component a node becomes (node, level). On level i a run waits for mark
i, and an edge climbs over the marks that it carries. When an edge passes the last mark, the run has
to meet an accepting state. Unnecessary copies are avoided:

- a component in which every cycle accepts, or none does, has one level;
- of the copies of a component, one strongly connected part is kept, which may be entered anywhere;
- a copy is accepting itself if it is on no rejecting cycle, so edges through such copies need
  nothing more; only other edges that pass the last mark lead to an extra accepting copy.

The result depends on the order of the levels, and on whether an edge that passes the last mark
climbs on. So several graphs are made, to be reduced and compared.

Source: Gastin and Oddoux, Fast LTL to Büchi automata translation, CAV 2001; Babiak, Badie,
Duret-Lutz, Křetínský and Strejček, Compositional approach to suspension and other improvements
to LTL translation, SPIN 2013.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import permutations
from operator import or_
from typing import Generic

from companion.ltl.budget import Budget
from companion.ltl.components import acyclic, components_by_name, strong_components
from companion.ltl.graph import LabelledEdge, LabelledGraph, Marks
from companion.ltl.labels import L
from companion.ltl.reductions.trimming import essential_marks, trimmed

MAX_CANDIDATE_EDGES = 40_000
"""The most edges of all candidates together, apart from the last candidate made."""

_State = tuple[int, int]
"""A node and its level."""

_Copy = tuple[int, int, bool]
"""A node, its level, and whether this is the accepting one of two copies."""

_Steps = Mapping[_State, Sequence[tuple[L, _State, bool]]]
"""For each state its edges: label, target, and whether the edge passes the last mark."""


def degeneralised(graph: LabelledGraph[L], budget: Budget) -> list[LabelledGraph[L]]:
    """Equivalent graphs with marks on states, for several orders of the levels; smallest first.

    Raises:
        TranslationLimit: the budget is spent.
    """
    useful = trimmed(graph)
    kinds = [_components(useful, saturated) for saturated in (False, True)]
    most = max(len(component.marks) for component in kinds[0])
    variants = [
        (components, turn, climbs_on)
        for turn in range(len(_orders(range(most))))
        for components in kinds[: 1 + most]
        for climbs_on in (False, True)[:most]
    ]
    found: list[LabelledGraph[L]] = []
    edges_left = MAX_CANDIDATE_EDGES
    for components, turn, climbs_on in variants or [(kinds[0], 0, False)]:
        if edges_left >= 0:
            found.append(_copied(components, turn, climbs_on, budget))
            edges_left -= found[-1].size[1]
    return sorted(found, key=lambda candidate: candidate.size)


@dataclass(frozen=True, slots=True)
class _Component(Generic[L]):
    """A strongly connected component.

    Attributes:
        inside: for each node the edges that stay in the component.
        outside: for each node the edges that leave it.
        marks: the marks that an accepting run has to meet, each as a set of one; if there are none,
            either all cycles accept or none does.
    """

    inside: Mapping[int, Sequence[LabelledEdge[L]]]
    outside: Mapping[int, Sequence[LabelledEdge[L]]]
    marks: Sequence[Marks]
    is_accepting: bool


def _components(graph: LabelledGraph[L], saturated: bool) -> list[_Component[L]]:
    """The components; each comes before those that lead to it.

    Args:
        saturated: whether edges also get each mark that is on every cycle through them.
    """
    components = []
    every_mark = (1 << graph.marks) - 1
    for nodes in strong_components(graph.successors):
        own = set(nodes)
        inside: Mapping[int, Sequence[LabelledEdge[L]]] = {
            node: [e for e in graph.edges[node] if e.target in own] for node in nodes
        }
        outside = {node: [e for e in graph.edges[node] if e.target not in own] for node in nodes}
        marks = [edge.marks for leaving in inside.values() for edge in leaving]
        is_accepting = bool(marks) and reduce(or_, marks) == every_mark
        needed = essential_marks(marks, graph.marks) if is_accepting else []
        for mark in needed if saturated else ():
            inside = _saturated(inside, mark)
        components.append(_Component(inside, outside, needed, is_accepting))
    return components


def _saturated(
    inside: Mapping[int, Sequence[LabelledEdge[L]]], mark: Marks
) -> Mapping[int, Sequence[LabelledEdge[L]]]:
    """The edges, with a mark (a set of one) added to all that are on no cycle without it."""
    without = {
        n: [e.target for e in leaving if not e.marks & mark] for n, leaving in inside.items()
    }
    parts = components_by_name(without)
    part_of = {node: number for number, part in enumerate(parts) for node in part}
    return {
        node: [
            edge
            if part_of[node] == part_of[edge.target]
            else edge._replace(marks=edge.marks | mark)
            for edge in leaving
        ]
        for node, leaving in inside.items()
    }


def _orders(marks: Sequence[Marks]) -> list[tuple[Marks, ...]]:
    """All orders of up to four marks; for more marks, their rotations in both directions."""
    if len(marks) <= 4:
        return list(permutations(marks))
    turned = [(*marks[i:], *marks[:i]) for i in range(len(marks))]
    return [*turned, *(order[::-1] for order in turned)]


def _copied(
    components: Iterable[_Component[L]], turn: int, climbs_on: bool, budget: Budget
) -> LabelledGraph[L]:
    """The graph of copies, for one order of levels in each component."""
    entry: dict[int, _Copy] = {}
    leaving: dict[_Copy, list[tuple[L, _Copy]]] = {}
    accepting: set[_Copy] = set()
    for component in components:  # from the last to the first
        orders = _orders(component.marks)
        steps = _levels(component, orders[turn % len(orders)], climbs_on, budget)
        passing = _off_rejecting_cycles(steps)
        doubled = _doubled(steps, passing)
        for node, level in steps:
            entry.setdefault(node, (node, level, False))
        for (node, level), edges in steps.items():
            budget.keep(2 * (len(edges) + len(component.outside[node])))
            plain, beside = (node, level, False), (node, level, True)
            leaving[plain] = leaving[beside] = [
                (label, (*target, passes and (node, level, *target) in doubled))
                for label, target, passes in edges
            ] + [(edge.label, entry[edge.target]) for edge in component.outside[node]]
            accepting.update({beside, plain} if (node, level) in passing else {beside})
    return _reached(leaving, entry[0], accepting)


def _levels(
    component: _Component[L], order: Sequence[Marks], climbs_on: bool, budget: Budget
) -> _Steps[L]:
    """One strongly connected part of the copies of a component."""
    top = len(order)
    start = (next(iter(component.inside)), 0)
    number_of = {start: 0}
    states = [start]
    edges: list[list[tuple[L, _State, bool]]] = []
    for node, level in states:  # grows while it is read
        edges.append([])
        budget.spend(10 * len(component.inside[node]))
        for label, marks, target in component.inside[node]:
            after = _climbed(level, marks, order)
            passes = component.is_accepting and after == top
            if after == top:
                after = _climbed(0, marks, order[:-1]) if climbs_on else 0
            state = (target, after)
            if number_of.setdefault(state, len(states)) == len(states):
                states.append(state)
            edges[-1].append((label, state, passes))
    parts = strong_components([[number_of[t] for _, t, _ in leaving] for leaving in edges])
    # components come after those that they reach, so the first one reaches no other
    return {states[i]: edges[i] for i in sorted(parts[0])}


def _climbed(level: int, marks: Marks, order: Sequence[Marks]) -> int:
    while level < len(order) and marks & order[level]:
        level += 1
    return level


def _off_rejecting_cycles(steps: _Steps[L]) -> set[_State]:
    """The states that are on no cycle of edges which do not pass the last mark."""
    return acyclic({s: [t for _, t, passes in edges if not passes] for s, edges in steps.items()})


def _doubled(steps: _Steps[L], passing: set[_State]) -> set[tuple[int, int, int, int]]:
    """Pairs of consecutive states on a cycle without any state that is off rejecting cycles.

    The second state has an extra accepting copy, to which edges from the first one lead.
    """
    rest = {
        s: [t for _, t, _ in edges if t not in passing]
        for s, edges in steps.items()
        if s not in passing
    }
    part_of = {state: i for i, part in enumerate(components_by_name(rest)) for state in part}
    return {(*s, *t) for s, targets in rest.items() for t in targets if part_of[s] == part_of[t]}


def _reached(
    leaving: Mapping[_Copy, Sequence[tuple[L, _Copy]]], start: _Copy, accepting: set[_Copy]
) -> LabelledGraph[L]:
    """The reachable graph, with a mark on the edges of accepting copies."""
    number_of = {start: 0}
    pending = [start]
    edges: list[list[LabelledEdge[L]]] = []
    for copy in pending:  # grows while it is read
        edges.append([])
        for label, target in leaving[copy]:
            number = number_of.setdefault(target, len(pending))
            if number == len(pending):
                pending.append(target)
            edges[-1].append(LabelledEdge(label, int(copy in accepting), number))
    return LabelledGraph(edges, 1)
