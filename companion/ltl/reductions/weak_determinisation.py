"""Weak determinisation: finds the smallest weak deterministic automaton of a language, if any.

Most missions are *obligations*: whether a run accepts depends only on the component in which it
finally stays. Their automata come from the powerset construction: a component accepts if one of its
cycles does, since all of them agree. If the language is not an obligation, the result accepts
another language; so it is compared with an automaton of the language and with one of its
complement. The smallest weak deterministic automaton of a language is unique.

Source: Löding, Efficient minimization of deterministic weak omega-automata, IPL 2001; Dax, Eisinger
and Klaedtke, Mechanizing the powerset construction for restricted classes of omega-automata,
ATVA 2007.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import or_

from companion.ltl.bitsets import indices
from companion.ltl.budget import Budget
from companion.ltl.components import strong_components
from companion.ltl.graph import LabelledEdge, LabelledGraph, Marks, Nodes, reachable
from companion.ltl.labels import LetterSet, highest_letter, lowest_letter
from companion.ltl.reductions.bisimulation import bisimilar, redirected
from companion.ltl.reductions.simulation import leaders

POWERSET_MARGIN = 8
"""The most states of a powerset for each state of the automaton."""

Steps = list[dict[int, LetterSet]]
"""For each state of a complete deterministic automaton the letters that lead to each target."""


@dataclass(frozen=True, slots=True)
class _WeakAutomaton:
    """A complete deterministic automaton; a run accepts if it stays among accepting states."""

    steps: Steps
    accepting: list[bool]


def weak_deterministic(
    graph: LabelledGraph[LetterSet],
    every: LetterSet,
    complement: Callable[[], LabelledGraph[LetterSet]],
    budget: Budget,
) -> LabelledGraph[LetterSet] | None:
    """The smallest weak deterministic automaton of a language; its dead state is left out.

    Args:
        graph: accepts the language.
        every: the set of all letters.
        complement: makes a graph that accepts all other words; called if it is needed.

    Returns:
        A graph with one mark, on all edges of accepting states; None if the language is no
        obligation.

    Raises:
        TranslationLimit: the budget is spent.
    """
    determined = _powerset(graph, every, budget)
    weak = determined and _coloured(graph, *determined)
    if weak is None or _meets(weak, graph, False, budget):
        return None
    return None if _meets(weak, complement(), True, budget) else _minimal(weak)


def _powerset(
    graph: LabelledGraph[LetterSet], every: LetterSet, budget: Budget
) -> tuple[Steps, list[Nodes]] | None:
    """The subset construction, and the nodes of each of its states; None if there are too many."""
    number_of = {1: 0}
    pending: list[Nodes] = [1]
    steps: Steps = []
    for nodes in pending:  # grows while it is read
        cells: dict[Nodes, LetterSet] = {0: every}  # the nodes that some letters lead to
        for node in indices(nodes):
            for label, _, target in graph.edges[node]:
                budget.spend(len(cells), every.bit_length())
                split: dict[Nodes, LetterSet] = defaultdict(LetterSet)
                for reached, letters in cells.items():
                    if letters & label:
                        split[reached | 1 << target] |= letters & label
                    if letters & ~label:
                        split[reached] |= letters & ~label
                cells = split
        for reached in cells:
            if reached not in number_of:
                number_of[reached] = len(pending)
                pending.append(reached)
        if len(pending) > POWERSET_MARGIN * len(graph.edges):
            return None
        steps.append({number_of[reached]: letters for reached, letters in cells.items()})
    return steps, pending


def _coloured(
    graph: LabelledGraph[LetterSet], steps: Steps, nodes_of: Sequence[Nodes]
) -> _WeakAutomaton | None:
    """The powerset with its accepting states; None if two cycles of a component disagree.

    States that are on no cycle get the colour that makes most states equal: a component's colour is
    even if it accepts and odd otherwise, and as high as the colours of its successors allow.
    """
    component_of: dict[int, int] = {}
    colours: list[int] = []
    top = 2 * len(steps)
    for component in strong_components(steps):
        component_of.update(dict.fromkeys(component, len(colours)))
        inside = set(component)
        after = [colours[component_of[t]] for n in component for t in steps[n] if t not in inside]
        colour = min(after, default=top + 1)
        if len(component) > 1 or component[0] in steps[component[0]]:
            verdicts = {
                _accepts(graph, nodes_of[component[0]], _cycle(steps, component, letter_of))
                for letter_of in (lowest_letter, highest_letter)
            }
            if len(verdicts) > 1:
                return None
            colour -= colour % 2 == verdicts.pop()
        colours.append(colour)
    accepting = [colours[component_of[n]] % 2 == 0 for n in range(len(steps))]
    return _WeakAutomaton(steps, accepting)


def _cycle(
    steps: Steps, component: list[int], letter_of: Callable[[LetterSet], LetterSet]
) -> list[LetterSet]:
    """Letters (each as a set of one) along a shortest cycle through the first of some states."""
    inside = set(component)
    came_from: dict[int, tuple[int, LetterSet]] = {}
    pending = [component[0]]
    for state in pending:  # grows while it is read
        for target, letters in steps[state].items():
            if target in inside and target not in came_from:
                came_from[target] = (state, letter_of(letters))
                pending.append(target)
    state, letter = came_from[component[0]]
    word = [letter]
    while state != component[0]:
        state, letter = came_from[state]
        word.append(letter)
    return word[::-1]


def _accepts(graph: LabelledGraph[LetterSet], nodes: Nodes, loop: Sequence[LetterSet]) -> bool:
    """Whether a word that repeats for ever is accepted from at least one of some nodes."""
    number_of = {(node, 0): i for i, node in enumerate(indices(nodes))}
    pending = list(number_of)
    successors: list[list[tuple[int, Marks]]] = []
    for node, place in pending:  # grows while it is read
        after = (place + 1) % len(loop)
        successors.append([])
        for label, marks, target in graph.edges[node]:
            if label & loop[place]:
                number = number_of.setdefault((target, after), len(pending))
                if number == len(pending):
                    pending.append((target, after))
                successors[-1].append((number, marks))
    return _has_accepting_cycle(successors, graph.marks, [True] * len(pending))


def _meets(
    weak: _WeakAutomaton, graph: LabelledGraph[LetterSet], accepting: bool, budget: Budget
) -> bool:
    """Whether a word of the graph makes the weak automaton accept, or reject."""
    number_of = {(0, 0): 0}
    pending = [(0, 0)]
    successors: list[list[tuple[int, Marks]]] = []
    for state, node in pending:  # grows while it is read
        successors.append([])
        budget.spend(len(graph.edges[node]) * len(weak.steps[state]))
        for label, marks, target in graph.edges[node]:
            for after, letters in weak.steps[state].items():
                if label & letters:
                    number = number_of.setdefault((after, target), len(pending))
                    if number == len(pending):
                        pending.append((after, target))
                    successors[-1].append((number, marks))
    is_wanted = [weak.accepting[state] is accepting for state, _ in pending]
    return _has_accepting_cycle(successors, graph.marks, is_wanted)


def _has_accepting_cycle(
    successors: Sequence[Sequence[tuple[int, Marks]]], marks: int, is_wanted: Sequence[bool]
) -> bool:
    """Whether a component of wanted nodes has all marks; given are the edges' targets and marks."""
    every_mark = (1 << marks) - 1
    for component in strong_components([[t for t, _ in leaving] for leaving in successors]):
        inside = set(component)
        met = [m for node in component for target, m in successors[node] if target in inside]
        if met and is_wanted[component[0]] and reduce(or_, met) == every_mark:
            return True
    return False


def _minimal(weak: _WeakAutomaton) -> LabelledGraph[LetterSet]:
    """The automaton with equivalent states merged, as in finite automata."""
    edges = [
        [LabelledEdge(letters, int(accepts), target) for target, letters in step.items()]
        for step, accepts in zip(weak.steps, weak.accepting, strict=True)
    ]
    leader = leaders(bisimilar(edges, [int(x) for x in weak.accepting], Budget.unlimited()))
    return reachable([redirected(leaving, leader) for leaving in edges], 1, leader[0])
