"""What is left of an automaton while some propositions keep their value?

A plan assumes that events keep their value and beliefs hold, and many facts no action changes.
Letters then differ in few propositions, and the automaton of a conjunct often shrinks to a state
or two: `G (F at(A) | targetFound)` is `G F at(A)` until a target is found, and nothing at all
afterwards. The formula is not translated again; the automaton is cut down and reduced.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations

from companion.ltl.automaton import BuchiAutomaton, Label, Transition, statistics
from companion.ltl.reduction import Edge, Graph, indices, merged, pruned, simulation


@dataclass(frozen=True)
class Restriction:
    """A reduced automaton, and where the states of the whole one are in it.

    Attributes:
        automaton: reads the propositions that are left; has no initial states of its own.
        state_of: for each state of the whole automaton its state here; no entry if it accepts
            nothing any more.
        simulators: for each state here the states (bits) that accept all that it accepts.
    """

    automaton: BuchiAutomaton
    state_of: Mapping[int, int]
    simulators: tuple[int, ...]

    def states(self, whole: frozenset[int]) -> list[int]:
        """The states for a set of states of the whole automaton; of equal ones the first.

        One that another simulates stays: its runs may close a loop sooner.
        """
        found = sorted({self.state_of[state] for state in whole if state in self.state_of})
        return [s for s in found if not any(self._are_equal(s, t) for t in found if t < s)]

    def _are_equal(self, one: int, other: int) -> bool:
        return bool(self.simulators[one] >> other & 1 and self.simulators[other] >> one & 1)

    @cached_property
    def everything(self) -> frozenset[int]:
        """States from which every word is accepted: they read all letters with every mark."""
        return frozenset(
            state
            for state, leaving in enumerate(self.automaton.outgoing)
            if len(leaving) == 1
            and leaving[0].target == state
            and not (leaving[0].label.positive or leaving[0].label.negative)
            and len(leaving[0].marks) == self.automaton.marks
        )

    @cached_property
    def errands(self) -> frozenset[int]:
        """States that wait for one letter of some kind, whatever else is read: `F p`."""
        if not statistics(replace(self.automaton, initial=frozenset({0}))).is_complete:
            return frozenset()
        found = set()
        for state, leaving in enumerate(self.automaton.outgoing):
            ends = {t.target for t in leaving} - {state}
            waiting = [t.marks for t in leaving if t.target == state]
            met = frozenset().union(*waiting)
            if waiting and ends and ends <= self.everything and len(met) < self.automaton.marks:
                found.add(state)
        return frozenset(found)


def restricted(automaton: BuchiAutomaton, constants: Mapping[str, bool]) -> Restriction:
    """An automaton for words in which the constants have the given values at every position."""
    names = [name for name in automaton.propositions if name not in constants]
    bit_of = {name: 1 << 2 * i for i, name in enumerate(names)}

    def bits(label: Label) -> int:
        """Two bits a proposition, as the reductions have them: p, !p."""
        positive = sum(bit_of[p] for p in label.positive if p in bit_of)
        return positive | sum(bit_of[p] << 1 for p in label.negative if p in bit_of)

    def is_possible(label: Label) -> bool:
        return all(constants.get(p, True) for p in label.positive) and not any(
            constants.get(p, False) for p in label.negative
        )

    # A root with an edge of its own label to each state keeps all of them reachable.
    first_tag = 2 * len(names)
    root = [Edge(1 << first_tag + 2 * state, 0, state + 1) for state in range(automaton.states)]
    inner = []
    for leaving in automaton.outgoing:
        labels: dict[tuple[int, int], set[int]] = defaultdict(set)
        for t in leaving:
            if is_possible(t.label):
                labels[sum(1 << mark for mark in t.marks), t.target + 1].add(bits(t.label))
        inner.append([Edge(label, *rest) for rest in labels for label in _joined(labels[rest])])
    graph = merged(pruned(Graph([root, *inner], automaton.marks)))
    state_of = {
        (edge.label.bit_length() - 1 - first_tag) // 2: edge.target - 1 for edge in graph.edges[0]
    }
    simulators = tuple(above >> 1 for above in simulation(graph)[1:])
    transitions = tuple(
        Transition(
            source, _label(edge.label, names), edge.target - 1, frozenset(indices(edge.marks))
        )
        for source, leaving in enumerate(graph.edges[1:])
        for edge in leaving
    )
    states = len(graph.edges) - 1
    reduced = BuchiAutomaton(states, frozenset(), transitions, graph.marks, automaton.name)
    return Restriction(reduced, state_of, simulators)


def _joined(cubes: set[int]) -> list[int]:
    """Fewer cubes that read the same: a & p and a & !p are a."""
    joined = set(cubes)
    for one, other in combinations(sorted(cubes), 2):
        differ = one ^ other
        low = differ & -differ
        is_pair = differ == 3 * low and low.bit_length() % 2 == 1
        if is_pair and (one & differ).bit_count() == 1 == (other & differ).bit_count():
            return _joined((joined - {one, other}) | {one & other})
    return sorted(joined)


def _label(bits: int, names: list[str]) -> Label:
    positive = frozenset(name for i, name in enumerate(names) if bits >> 2 * i & 1)
    negative = frozenset(name for i, name in enumerate(names) if bits >> 2 * i & 2)
    return Label(positive, negative)
