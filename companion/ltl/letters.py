"""Which letters does a label read? Labels as cubes, as sets of letters, and back.

Inside the translator an automaton is a bare graph (`reduction.py`) whose labels are ints. As a
*cube* a label has two bits a proposition: p, !p. A cube cannot say what two labels read together,
or what one reads and another does not; a *set of letters*, with a bit for each letter, can. So
sets are used where the letters are few.

Of *exclusive* propositions at most one holds at a time (a vehicle is at one place). Letters with
two of them do not occur, so 50 places make 51 letters.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from functools import cached_property

from companion.ltl.automaton import BuchiAutomaton, Label, Transition
from companion.ltl.budget import Budget
from companion.ltl.reduction import Edge, Graph, indices, reachable

MAX_LETTERS = 4096
"""Letters up to which sets of them are used: ints of 512 bytes."""


class Alphabet:
    """The letters over some propositions; number i of these has bits 2 i and 2 i + 1 of a cube."""

    def __init__(self, names: Sequence[str], exclusive: frozenset[str] = frozenset()) -> None:
        self.names = tuple(names)
        self.exclusive = exclusive.intersection(names)
        self._number_of = {name: i for i, name in enumerate(names)}
        self._size = (len(self.exclusive) + 1) << (len(self.names) - len(self.exclusive))
        self._letters_of: dict[int, int] = {}
        self._cube_of: dict[int, int] = {}

    @property
    def is_small(self) -> bool:
        """Whether labels may be sets of letters."""
        return self._size <= MAX_LETTERS

    @cached_property
    def every(self) -> int:
        """The set of all letters."""
        return (1 << self._size) - 1

    @cached_property
    def _literals(self) -> list[int]:
        """The letters of each literal: p, !p, q, !q, ...

        A letter is a block of 2^f letters, for f propositions that are not exclusive, and a place
        in it: in block 0 no exclusive proposition holds, in block i the i-th of them.
        """
        places = [i for i, name in enumerate(self.names) if name in self.exclusive]
        free = [i for i, name in enumerate(self.names) if name not in self.exclusive]
        block = 1 << len(free)
        positive = [0] * len(self.names)
        for number, i in enumerate(places, 1):
            positive[i] = ((1 << block) - 1) << block * number
        for number, i in enumerate(free):
            period = 2 << number
            pattern = ((1 << period // 2) - 1) << period // 2
            while period < self._size:
                pattern |= pattern << period
                period *= 2
            positive[i] = pattern & self.every
        return [side for letters in positive for side in (letters, self.every & ~letters)]

    def letters(self, cube: int) -> int:
        """The letters that a cube reads."""
        if cube not in self._letters_of:
            found = self.every
            for i in indices(cube):
                found &= self._literals[i]
            self._letters_of[cube] = found
            self._cube_of[found] = cube
        return self._letters_of[cube]

    def cubes(self, letters: int) -> list[int]:
        """Disjoint cubes that together read these letters."""
        found = []
        while letters:
            cube = self._cube_of.get(letters)
            if cube is None:
                ends = (letters & -letters, 1 << letters.bit_length() - 1)
                cube = max((self._widened(letter, letters) for letter in ends), key=self._reads)
            found.append(cube)
            letters &= ~self.letters(cube)
        return found

    def _reads(self, cube: int) -> int:
        return self.letters(cube).bit_count()

    def _widened(self, letter: int, within: int) -> int:
        """A cube around a letter that reads nothing outside a set, and has no literal too many."""
        literals = [i for i, letters in enumerate(self._literals) if letters & letter]
        left = [self.every]  # what literals read together: none, the last, the last two, ...
        for i in reversed(literals):
            left.append(left[-1] & self._literals[i])
        cube, read = 0, self.every
        for i in literals:
            left.pop()
            if read & left[-1] & ~within:
                cube |= 1 << i
                read &= self._literals[i]
        return cube

    def cube(self, label: Label) -> int:
        """A label as a cube."""
        positive = sum(1 << 2 * self._number_of[name] for name in label.positive)
        return positive | sum(2 << 2 * self._number_of[name] for name in label.negative)

    def label(self, cube: int) -> Label:
        """A cube as a label."""
        literals = [divmod(i, 2) for i in indices(cube)]
        positive, negative = (
            frozenset(self.names[number] for number, is_negated in literals if is_negated == sign)
            for sign in (0, 1)
        )
        return Label(positive, negative)


def with_letters(graph: Graph, alphabet: Alphabet, budget: Budget) -> Graph:
    """The graph with sets of letters as labels, given one with cubes."""
    edges: list[list[Edge]] = []
    for leaving in graph.edges:
        letters: dict[tuple[int, int], int] = defaultdict(int)
        for cube, marks, target in leaving:
            letters[marks, target] |= alphabet.letters(cube)
        budget.keep(len(letters), alphabet.every.bit_length())
        edges.append([Edge(read, *rest) for rest, read in letters.items() if read])
    return Graph(edges, graph.marks)


def with_cubes(graph: Graph, alphabet: Alphabet, budget: Budget) -> Graph:
    """The graph with cubes as labels, given one with sets of letters."""
    cubes_of: dict[int, list[int]] = {}
    edges: list[list[Edge]] = []
    for leaving in graph.edges:
        edges.append([])
        for letters, marks, target in leaving:
            if letters not in cubes_of:
                cubes_of[letters] = alphabet.cubes(letters)
                literals = 2 * len(alphabet.names)
                budget.spend(literals * len(cubes_of[letters]), alphabet.every.bit_length())
            edges[-1] += [Edge(cube, marks, target) for cube in cubes_of[letters]]
            budget.keep(len(cubes_of[letters]))
    return Graph(edges, graph.marks)


def graph_of(automaton: BuchiAutomaton, alphabet: Alphabet) -> Graph:
    """The graph of an automaton, with cubes as labels.

    Node 0 is the initial state, or a new one if there are several.
    """
    edges = [
        [
            Edge(alphabet.cube(t.label), sum(1 << mark for mark in t.marks), t.target)
            for t in leaving
        ]
        for leaving in automaton.outgoing
    ]
    initial = sorted(automaton.initial)
    if len(initial) != 1:
        edges.append([edge for state in initial for edge in edges[state]])
        initial = [len(edges) - 1]
    return reachable(edges, automaton.marks, initial[0])


def automaton_of(graph: Graph, alphabet: Alphabet, name: str) -> BuchiAutomaton:
    """The automaton of a graph with cubes as labels."""
    cubes = {edge.label for leaving in graph.edges for edge in leaving}
    labels = {cube: alphabet.label(cube) for cube in cubes}
    transitions = tuple(
        Transition(source, labels[edge.label], edge.target, frozenset(indices(edge.marks)))
        for source, leaving in enumerate(graph.edges)
        for edge in leaving
    )
    states, initial = len(graph.edges), frozenset({0})
    return BuchiAutomaton(states, initial, transitions, graph.marks, name, alphabet.exclusive)
