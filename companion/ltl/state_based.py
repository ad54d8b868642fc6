"""Which automaton has one acceptance set, and it a set of states?

In a strongly connected component a node becomes (node, level): on level i a run waits for mark
i, and an edge climbs over the marks that it carries. Where it passes the last one the run has to
meet an accepting state. What need not be copied is not:

- a component where every cycle accepts, or none, has one level;
- of the copies of a component one strongly connected part is kept, and entered anywhere in it;
- a copy accepts itself if it lies on no rejecting cycle, so edges that lead through such copies
  have met theirs; only other edges that pass the last mark lead to an accepting twin.

The order of the levels matters, and so does whether an edge that passes the last mark climbs on.
Several automata are made, and the most promising ones reduced by simulation.

Source: Gastin and Oddoux, Fast LTL to Büchi automata translation, CAV 2001; Babiak, Badie,
Duret-Lutz, Křetínský and Strejček, Compositional approach to suspension and other improvements
to LTL translation, SPIN 2013.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial, reduce
from itertools import permutations
from operator import or_
from typing import TypeVar

from companion.ltl.automaton import BuchiAutomaton, strong_components
from companion.ltl.budget import Budget, TranslationLimit
from companion.ltl.letters import Alphabet, automaton_of, graph_of, with_cubes, with_letters
from companion.ltl.quotient import Relation, merged, merged_backwards
from companion.ltl.reduction import Edge, Graph, essential_marks, pruned, reachable
from companion.ltl.reduction import merged as merged_cubes
from companion.ltl.simulation import equals, simulators

MAX_CANDIDATE_EDGES = 40_000
"""How many edges of automata are made before they are compared."""

FIRST_STEPS = 8_000_000
"""What reducing the most promising of them by simulation may cost."""

OTHER_STEPS = 200_000
"""What reducing all others may cost."""

_State = tuple[int, int]
"""A node and its level."""

_Copy = tuple[int, int, bool]
"""A node, its level, and whether it is the accepting twin."""

_Steps = Mapping[_State, Sequence[tuple[int, _State, bool]]]
"""For each state the labels and targets of its edges, and whether they pass the last mark."""

_K = TypeVar("_K", bound=Hashable)


def state_based(automaton: BuchiAutomaton, budget: Budget | None = None) -> BuchiAutomaton:
    """An equivalent automaton whose one acceptance set is a set of states.

    The transitions of an accepting state carry mark 0, and no others do.

    Raises:
        TranslationLimit: the budget, by default a new one, does not suffice.
    """
    budget = budget or Budget()
    alphabet = Alphabet(automaton.propositions, automaton.exclusive)
    graph = graph_of(automaton, alphabet)
    if alphabet.is_small:
        candidates = _candidates(with_letters(graph, alphabet, budget), budget)
        found = with_cubes(_smallest(candidates), alphabet, budget)
    else:
        found = _settled(_candidates(graph, budget)[0], False)
        if not found.is_large:
            found = _reduced(found, False, merged_cubes)
    return automaton_of(found, alphabet, automaton.name)


def _smallest(candidates: Sequence[Graph]) -> Graph:
    """The smallest graph that is found from the most promising ones."""
    best = _settled(candidates[0], False)
    first, others = Budget(FIRST_STEPS), Budget(OTHER_STEPS)
    trials = [(equals, candidates[0], False)]
    trials += [(simulators, graph, passing) for graph in candidates for passing in (False, True)]
    try:
        for relation, candidate, in_passing in trials:
            budget = first if candidate is candidates[0] else others
            merge = partial(_merged, relation=partial(relation, budget=budget))
            best = min(best, _reduced(candidate, in_passing, merge), key=lambda known: known.size)
    except TranslationLimit:
        pass  # what was found so far is right as well
    return best


def _reduced(graph: Graph, in_passing: bool, merge: Callable[[Graph], Graph]) -> Graph:
    graph = _settled(graph, in_passing)
    while (smaller := _settled(merge(graph), in_passing)).size != graph.size:
        graph = smaller
    return graph


def _merged(graph: Graph, relation: Relation) -> Graph:
    smaller = merged(graph, relation)
    accepting = [int(any(edge.marks for edge in leaving)) for leaving in smaller.edges]
    return merged_backwards(smaller, accepting, relation)


@dataclass(frozen=True, slots=True)
class _Component:
    """A strongly connected component.

    Attributes:
        inside: for each node the edges that stay.
        outside: for each node the edges that leave.
        marks: those that a run has to meet to accept, as bits; if none, either all cycles accept
            or none does.
    """

    inside: Mapping[int, Sequence[Edge]]
    outside: Mapping[int, Sequence[Edge]]
    marks: Sequence[int]
    is_accepting: bool


def _components(graph: Graph, saturated: bool) -> list[_Component]:
    """The components, each before those that lead to it.

    Args:
        saturated: edges have a mark as well if every cycle through them has it.
    """
    components = []
    every_mark = (1 << graph.marks) - 1
    for nodes in strong_components([[e.target for e in leaving] for leaving in graph.edges]):
        own = set(nodes)
        inside: Mapping[int, Sequence[Edge]] = {
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


def _saturated(inside: Mapping[int, Sequence[Edge]], mark: int) -> Mapping[int, Sequence[Edge]]:
    """With a mark (as a bit) on all edges that are on no cycle without it."""
    without = {
        n: [e.target for e in leaving if not e.marks & mark] for n, leaving in inside.items()
    }
    part_of = {node: number for number, part in enumerate(_parts(without)) for node in part}
    return {
        node: [
            edge
            if part_of[node] == part_of[edge.target]
            else edge._replace(marks=edge.marks | mark)
            for edge in leaving
        ]
        for node, leaving in inside.items()
    }


def _candidates(graph: Graph, budget: Budget) -> list[Graph]:
    """Equivalent graphs with marks on states, for several orders of the levels; smallest first."""
    kinds = [_components(pruned(graph), saturated) for saturated in (False, True)]
    most = max(len(component.marks) for component in kinds[0])
    variants = [
        (components, turn, climbs_on)
        for turn in range(len(_orders(range(most))))
        for components in kinds[: 1 + most]
        for climbs_on in (False, True)[:most]
    ]
    found: list[Graph] = []
    edges_left = MAX_CANDIDATE_EDGES
    for components, turn, climbs_on in variants or [(kinds[0], 0, False)]:
        if edges_left >= 0:
            found.append(_spread(components, turn, climbs_on, budget))
            edges_left -= found[-1].size[1]
    return sorted(found, key=lambda candidate: candidate.size)


def _orders(marks: Sequence[int]) -> list[tuple[int, ...]]:
    """All orders of up to four marks; of more their rotations, forwards and backwards."""
    if len(marks) <= 4:
        return list(permutations(marks))
    turned = [(*marks[i:], *marks[:i]) for i in range(len(marks))]
    return [*turned, *(order[::-1] for order in turned)]


def _spread(components: Iterable[_Component], turn: int, climbs_on: bool, budget: Budget) -> Graph:
    """The graph of copies, for an order of levels in each component."""
    entry: dict[int, _Copy] = {}
    leaving: dict[_Copy, list[tuple[int, _Copy]]] = {}
    accepting: set[_Copy] = set()
    for component in components:  # from the last to the first
        orders = _orders(component.marks)
        steps = _levels(component, orders[turn % len(orders)], climbs_on, budget)
        calm = _off_cycles(steps)
        twins = _in_need(steps, calm)
        for node, level in steps:
            entry.setdefault(node, (node, level, False))
        for (node, level), edges in steps.items():
            budget.keep(2 * (len(edges) + len(component.outside[node])))
            plain, twin = (node, level, False), (node, level, True)
            leaving[plain] = leaving[twin] = [
                (label, (*target, passes and (node, level, *target) in twins))
                for label, target, passes in edges
            ] + [(edge.label, entry[edge.target]) for edge in component.outside[node]]
            accepting.update({twin, plain} if (node, level) in calm else {twin})
    return _graph(leaving, entry[0], accepting)


def _levels(component: _Component, order: Sequence[int], climbs_on: bool, budget: Budget) -> _Steps:
    """One strongly connected part of the copies of a component, by level."""
    top = len(order)
    start = (next(iter(component.inside)), 0)
    number_of = {start: 0}
    states = [start]
    edges: list[list[tuple[int, _State, bool]]] = []
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
    # a component comes after those that it reaches: the first one reaches no other
    return {states[i]: edges[i] for i in sorted(parts[0])}


def _climbed(level: int, marks: int, order: Sequence[int]) -> int:
    while level < len(order) and marks & order[level]:
        level += 1
    return level


def _off_cycles(steps: _Steps) -> set[_State]:
    """States on no cycle of edges that do not pass the last mark."""
    rejecting = {s: [t for _, t, passes in edges if not passes] for s, edges in steps.items()}
    return {s for part in _parts(rejecting) for s in part if not (part[1:] or s in rejecting[s])}


def _in_need(steps: _Steps, calm: set[_State]) -> set[tuple[int, int, int, int]]:
    """Pairs of states, one after the other on a cycle that no calm state lies on."""
    restless = {
        s: [t for _, t, _ in edges if t not in calm] for s, edges in steps.items() if s not in calm
    }
    part_of = {state: number for number, part in enumerate(_parts(restless)) for state in part}
    return {
        (*s, *t) for s, targets in restless.items() for t in targets if part_of[s] == part_of[t]
    }


def _parts(successors: Mapping[_K, Sequence[_K]]) -> list[list[_K]]:
    """Strongly connected components; successors without an entry do not count."""
    keys = list(successors)
    number_of = {key: number for number, key in enumerate(keys)}
    parts = strong_components(
        [[number_of[t] for t in successors[key] if t in number_of] for key in keys]
    )
    return [[keys[number] for number in part] for part in parts]


def _graph(
    leaving: Mapping[_Copy, Sequence[tuple[int, _Copy]]], start: _Copy, accepting: set[_Copy]
) -> Graph:
    """The graph of what is reached, with a mark on the edges of accepting copies."""
    number_of = {start: 0}
    pending = [start]
    edges: list[list[Edge]] = []
    for copy in pending:  # grows while it is read
        edges.append([])
        for label, target in leaving[copy]:
            number = number_of.setdefault(target, len(pending))
            if number == len(pending):
                pending.append(target)
            edges[-1].append(Edge(label, int(copy in accepting), number))
    return Graph(edges, 1)


def _settled(graph: Graph, in_passing: bool) -> Graph:
    """Without nodes that accept nothing; all others accept that may.

    Args:
        in_passing: whether nodes on no cycle accept; it does not matter for the language.
    """
    accepting = {node for node, leaving in enumerate(graph.edges) if leaving and leaving[0].marks}
    alive: set[int] = set()
    for nodes in strong_components([[e.target for e in leaving] for leaving in graph.edges]):
        own = set(nodes)
        inside = {n: [e.target for e in graph.edges[n] if e.target in own] for n in nodes}
        if not any(inside.values()):
            accepting = accepting | own if in_passing else accepting - own
        elif own & accepting:
            alive |= own
            rest = {n: inside[n] for n in nodes if n not in accepting}
            accepting.update(
                n for part in _parts(rest) for n in part if not (part[1:] or n in rest[n])
            )
        if any(edge.target in alive for node in nodes for edge in graph.edges[node]):
            alive |= own
    edges = [
        [Edge(e.label, int(node in accepting), e.target) for e in leaving if e.target in alive]
        for node, leaving in enumerate(graph.edges)
    ]
    return reachable(edges, 1)
