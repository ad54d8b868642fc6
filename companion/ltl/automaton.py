"""Generalized Büchi automata, with acceptance marks on transitions.

A label is a cube, a conjunction of literals; a letter is the set of propositions that hold at one
position. A run is accepting if it meets every acceptance set infinitely often; the sets are
numbered from 0 to `marks` - 1, and without any every infinite run is accepting. An automaton may be
nondeterministic and incomplete: a word without a run is rejected.

Source: Couvreur, On-the-fly verification of linear temporal logic, FM 1999; the paper's
definition of a Büchi automaton (Section II-D) is the case of one acceptance set.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import networkx


@dataclass(frozen=True, slots=True)
class Label:
    """A cube: propositions that must hold and propositions that must not."""

    positive: frozenset[str]
    negative: frozenset[str]

    def matches(self, letter: frozenset[str]) -> bool:
        """Whether a transition with this label can read a letter."""
        return self.positive <= letter and self.negative.isdisjoint(letter)

    def __str__(self) -> str:
        literals = sorted([(p, p) for p in self.positive] + [(n, f"!{n}") for n in self.negative])
        return " & ".join(text for _, text in literals) or "true"


@dataclass(frozen=True, slots=True)
class Transition:
    """An edge of the automaton; `marks` are the acceptance sets that it belongs to."""

    source: int
    label: Label
    target: int
    marks: frozenset[int]


@dataclass(frozen=True)
class BuchiAutomaton:
    """A transition-based generalized Büchi automaton.

    Attributes:
        states: number of states; they are numbered from 0.
        marks: number of acceptance sets; they are numbered from 0.
        name: what the automaton accepts, for people.
        exclusive: propositions of which at most one holds at a time; letters with two of them may
            be accepted or not.
    """

    states: int
    initial: frozenset[int]
    transitions: tuple[Transition, ...]
    marks: int
    name: str = ""
    exclusive: frozenset[str] = frozenset()

    @cached_property
    def propositions(self) -> tuple[str, ...]:
        """The propositions that the labels mention, sorted."""
        labels = [transition.label for transition in self.transitions]
        return tuple(sorted(frozenset().union(*(x.positive | x.negative for x in labels))))

    @cached_property
    def outgoing(self) -> tuple[tuple[Transition, ...], ...]:
        """The transitions of each state."""
        leaving: list[list[Transition]] = [[] for _ in range(self.states)]
        for transition in self.transitions:
            leaving[transition.source].append(transition)
        return tuple(map(tuple, leaving))

    def to_networkx(self) -> networkx.MultiDiGraph:
        """The automaton as a networkx graph, with the text of a label and the marks on each edge.

        >>> from companion.ltl.parser import parse
        >>> from companion.ltl.translate import translate
        >>> graph = translate(parse("G F p")).to_networkx()
        >>> list(graph.nodes(data="initial"))
        [(0, True)]
        >>> list(graph.edges(data=True))
        [(0, 0, {'label': 'p', 'marks': (0,)}), (0, 0, {'label': '!p', 'marks': ()})]

        Returns:
            States as nodes, with `initial`; transitions as edges, with `label` and `marks`; the
            graph has `name` and `marks`, how many there are.
        """
        import networkx  # takes longer to load than most automata to make

        graph = networkx.MultiDiGraph(name=self.name, marks=self.marks)
        for state in range(self.states):
            graph.add_node(state, initial=state in self.initial)
        for t in self.transitions:
            graph.add_edge(t.source, t.target, label=str(t.label), marks=tuple(sorted(t.marks)))
        return graph

    @cached_property
    def has_state_acceptance(self) -> bool:
        """Whether marks belong to states: all transitions of a state carry the same ones."""
        return all(len({t.marks for t in leaving}) <= 1 for leaving in self.outgoing)


@dataclass(frozen=True, slots=True)
class Statistics:
    """The size and the properties of an automaton.

    Attributes:
        is_deterministic: whether a word has at most one run.
        is_complete: whether every word has a run.
    """

    states: int
    transitions: int
    marks: int
    propositions: int
    is_deterministic: bool
    is_complete: bool


def statistics(automaton: BuchiAutomaton) -> Statistics:
    """The statistics of an automaton; unreachable states count as well."""
    labels = [[transition.label for transition in leaving] for leaving in automaton.outgoing]
    return Statistics(
        automaton.states,
        len(automaton.transitions),
        automaton.marks,
        len(automaton.propositions),
        len(automaton.initial) <= 1 and not any(map(_overlap, labels)),
        len(automaton.initial) >= 1 and all(map(_match_every_letter, labels)),
    )


def _overlap(labels: Sequence[Label]) -> bool:
    """Whether some letter matches two of the labels."""
    return any(
        a.positive.isdisjoint(b.negative) and a.negative.isdisjoint(b.positive)
        for a, b in combinations(labels, 2)
    )


def _match_every_letter(labels: Sequence[Label]) -> bool:
    """Whether each letter matches some label.

    Letters that match a label of one literal are removed first; the rest is split at a proposition.
    """
    pending = [
        [
            frozenset([(p, True) for p in x.positive] + [(p, False) for p in x.negative])
            for x in labels
        ]
    ]
    while pending:
        cubes = pending.pop()
        literals = frozenset().union(*(cube for cube in cubes if len(cube) == 1))
        negated = frozenset((name, not sign) for name, sign in literals)
        if frozenset() in cubes or literals & negated:
            continue
        if literals:
            pending.append([cube - negated for cube in cubes if cube.isdisjoint(literals)])
        elif cubes:
            # without this literal the cube reads nothing, so that half is examined first
            name, sign = min(cubes[0])
            pending += [[*cubes, frozenset({(name, side)})] for side in (not sign, sign)]
        else:
            return False
    return True


def successors(
    automaton: BuchiAutomaton, states: Iterable[int], letter: frozenset[str]
) -> frozenset[int]:
    """One step of the subset construction: the states of runs after they have read a letter."""
    outgoing = automaton.outgoing
    return frozenset(t.target for s in states for t in outgoing[s] if t.label.matches(letter))
