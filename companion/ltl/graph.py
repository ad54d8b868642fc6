"""Automata under construction: bare graphs whose labels are cubes or sets of letters.

The tableau makes a `LabelledGraph[Cube]`, and a `BuchiAutomaton` is made from one. Most reductions
work on `LabelledGraph[LetterSet]`. Node 0 is initial. Acceptance marks and sets of nodes are bits
of an int (`bitsets.py`).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import or_
from typing import Generic, NamedTuple

from companion.ltl.automaton import BuchiAutomaton, Transition
from companion.ltl.bitsets import indices
from companion.ltl.budget import Budget
from companion.ltl.components import strong_components
from companion.ltl.labels import Alphabet, Cube, L, LetterSet

Marks = int
"""A set of acceptance marks, as bits."""

Nodes = int
"""A set of nodes, as bits."""


class LabelledEdge(NamedTuple, Generic[L]):
    """A transition; its source is the node in whose list it is."""

    label: L
    marks: Marks
    target: int


@dataclass(frozen=True, slots=True)
class LabelledGraph(Generic[L]):
    """An automaton; node 0 is initial.

    Attributes:
        edges: the edges that leave each node.
        marks: number of acceptance sets.
    """

    edges: list[list[LabelledEdge[L]]]
    marks: int

    @property
    def size(self) -> tuple[int, int, int]:
        """Nodes, edges, marks."""
        return (len(self.edges), sum(map(len, self.edges)), self.marks)

    @property
    def successors(self) -> list[list[int]]:
        """The targets of the edges of each node."""
        return [[edge.target for edge in leaving] for leaving in self.edges]


def reachable(
    edges: Sequence[Sequence[LabelledEdge[L]]], marks: int, start: int = 0
) -> LabelledGraph[L]:
    """The graph that is reachable from a node, renumbered in the order of discovery."""
    return renumbered(edges, marks, start)[0]


def renumbered(
    edges: Sequence[Sequence[LabelledEdge[L]]], marks: int, start: int = 0
) -> tuple[LabelledGraph[L], dict[int, int]]:
    """The graph that is reachable from a node, and the new numbers by the old ones."""
    number_of = {start: 0}
    pending = [start]
    kept = []
    for node in pending:  # grows while it is read
        for _, _, target in edges[node]:
            if target not in number_of:
                number_of[target] = len(number_of)
                pending.append(target)
        kept.append([LabelledEdge(x, met, number_of[target]) for x, met, target in edges[node]])
    return LabelledGraph(kept, marks), number_of


def product(
    start: tuple[int, int],
    leaving: Callable[[tuple[int, int]], Iterable[tuple[LetterSet, Marks, tuple[int, int]]]],
    marks: int,
    budget: Budget,
    width: int,
) -> LabelledGraph[LetterSet]:
    """The graph of the pairs that are reachable from a pair; equal edges are joined.

    Args:
        start: the initial pair.
        leaving: the edges of a pair, with the pairs to which they lead.
        marks: number of acceptance sets.
        width: bits of a label.

    Raises:
        TranslationLimit: the budget is spent.
    """
    number_of = {start: 0}
    pending = [start]
    edges: list[list[LabelledEdge[LetterSet]]] = []
    for pair in pending:  # grows while it is read
        joint: dict[tuple[Marks, int], LetterSet] = defaultdict(LetterSet)
        for letters, met, target in leaving(pair):
            number = number_of.setdefault(target, len(pending))
            if number == len(pending):
                pending.append(target)
            joint[met, number] |= letters
        budget.keep(len(joint), width)
        edges.append([LabelledEdge(letters, *kind) for kind, letters in joint.items()])
    return LabelledGraph(edges, marks)


def accepting_nodes(graph: LabelledGraph[L]) -> set[int]:
    """The nodes of the strongly connected components in which a run can stay and accept."""
    every_mark = (1 << graph.marks) - 1
    found: set[int] = set()
    for component in strong_components(graph.successors):
        own = set(component)
        inside = [e.marks for node in component for e in graph.edges[node] if e.target in own]
        if inside and reduce(or_, inside) == every_mark:
            found |= own
    return found


def is_deterministic(graph: LabelledGraph[LetterSet]) -> bool:
    """Whether no two edges of a node read the same letter."""
    return not any(map(overlap, graph.edges))


def overlap(edges: Iterable[LabelledEdge[LetterSet]]) -> bool:
    """Whether two of the edges read the same letter."""
    read = LetterSet(0)
    for edge in edges:
        if read & edge.label:
            return True
        read |= edge.label
    return False


def with_letters(
    graph: LabelledGraph[Cube], alphabet: Alphabet, budget: Budget
) -> LabelledGraph[LetterSet]:
    """Converts a graph with cubes to sets of letters as labels."""
    edges: list[list[LabelledEdge[LetterSet]]] = []
    for leaving in graph.edges:
        letters: dict[tuple[Marks, int], LetterSet] = defaultdict(LetterSet)
        for cube, marks, target in leaving:
            letters[marks, target] |= alphabet.letters(cube)
        budget.keep(len(letters), alphabet.every.bit_length())
        edges.append([LabelledEdge(read, *rest) for rest, read in letters.items() if read])
    return LabelledGraph(edges, graph.marks)


def with_cubes(
    graph: LabelledGraph[LetterSet], alphabet: Alphabet, budget: Budget
) -> LabelledGraph[Cube]:
    """Converts a graph with sets of letters to cubes as labels."""
    cubes_of: dict[LetterSet, list[Cube]] = {}
    edges: list[list[LabelledEdge[Cube]]] = []
    for leaving in graph.edges:
        edges.append([])
        for letters, marks, target in leaving:
            if letters not in cubes_of:
                cubes_of[letters] = alphabet.cubes(letters)
                literals = 2 * len(alphabet.names)
                budget.spend(literals * len(cubes_of[letters]), alphabet.every.bit_length())
            edges[-1] += [LabelledEdge(cube, marks, target) for cube in cubes_of[letters]]
            budget.keep(len(cubes_of[letters]))
    return LabelledGraph(edges, graph.marks)


def graph_of(automaton: BuchiAutomaton, alphabet: Alphabet) -> LabelledGraph[Cube]:
    """The graph of an automaton.

    Node 0 is the initial state, or a new state if several are initial.
    """
    edges = [
        [
            LabelledEdge(alphabet.cube(t.label), sum(1 << mark for mark in t.marks), t.target)
            for t in leaving
        ]
        for leaving in automaton.outgoing
    ]
    initial = sorted(automaton.initial)
    if len(initial) != 1:
        edges.append([edge for state in initial for edge in edges[state]])
        initial = [len(edges) - 1]
    return reachable(edges, automaton.marks, initial[0])


def automaton_of(
    graph: LabelledGraph[Cube],
    alphabet: Alphabet,
    name: str,
    initial: frozenset[int] = frozenset({0}),
) -> BuchiAutomaton:
    """The automaton of a graph."""
    cubes = {edge.label for leaving in graph.edges for edge in leaving}
    labels = {cube: alphabet.label(cube) for cube in cubes}
    transitions = tuple(
        Transition(source, labels[edge.label], edge.target, frozenset(indices(edge.marks)))
        for source, leaving in enumerate(graph.edges)
        for edge in leaving
    )
    states, exclusive = len(graph.edges), alphabet.exclusive
    return BuchiAutomaton(states, initial, transitions, graph.marks, name, exclusive)
