"""The product of the task model and the automata, built only where the search goes.

A node is a set of facts together with one state per automaton (Section III-A):

    s -> s'  and  z_i --L(s')--> z_i'  for every i   gives   (s, z) -> (s', z')

The automata have read the position they are at (see `lasso.py`). A nondeterministic automaton makes
several edges, so a path through the product fixes one run of each. Acceptance stays generalized.
A node also says which acceptance sets (marks) were met on the way into it, so that a loop meets
a mark exactly if it passes a node that has it.

Constants (`system.py`) are taken out of facts and automata first (`ltl/restriction.py`); what is
left of a patrol are the places alone.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from companion.errors import NoPlanError
from companion.ltl.automaton import BuchiAutomaton
from companion.ltl.restriction import Restriction, restricted
from companion.planning.builtin.system import TransitionSystem, Vocabulary
from companion.planning.effort import ON_THE_GROUND
from companion.planning.lasso import Conjunct, Problem

MIN_ERRANDS = 4
"""Things to be met once that are kept out of the product, if there are so many: each of them
would double it."""

Node = tuple[int, tuple[int, ...], int]
"""Facts, states of the automata, marks met on the way in."""


class SearchLimit(NoPlanError):
    """The search was given up at its limit; there may be a plan."""


class Restrictions:
    """The conjuncts' automata under constants, kept from plan to plan."""

    def __init__(self) -> None:
        self._found: dict[tuple[int, tuple[bool | None, ...]], tuple[Conjunct, Restriction]] = {}

    def of(self, conjunct: Conjunct, constants: Callable[[str], bool | None]) -> Restriction:
        """A conjunct's automaton, given the values of propositions; None where they change."""
        names = conjunct.automaton.propositions
        values = tuple(map(constants, names))
        key = (id(conjunct), values)
        found = self._found.get(key)
        if found is None:
            fixed = {n: v for n, v in zip(names, values, strict=True) if v is not None}
            found = (conjunct, restricted(conjunct.automaton, fixed))
            self._found[key] = found  # holding the conjunct keeps its identity its own
        return found[1]


class Product:
    """The reachable product of a problem.

    Attributes:
        nodes: how many.
        roots: nodes at which a plan may begin.
        marks: for each node the marks (bits) met on the way into it.
        twins: for each node the first that differs from it in its marks alone. All that can be
            done after one can be done after the other, so a plan may enter a loop at either.
        all_marks: what a loop has to meet.
        errands: for each thing that has to be met once, the nodes where it is.
        targets, costs, actions: of the edges; those of node n are first[n] to first[n + 1].
            Between two nodes only the cheapest edge is kept, in the order of the actions.
    """

    def __init__(
        self,
        problem: Problem,
        vocabulary: Vocabulary,
        restrictions: Restrictions,
        max_edges: int = ON_THE_GROUND.edges,
    ) -> None:
        steps = vocabulary.steps(problem.actions)
        self._system = TransitionSystem(steps, vocabulary.mask(problem.facts))
        self._readers: list[_Reader] = []
        choices: list[list[int]] = []
        marks = 0

        def constant(proposition: str) -> bool | None:
            bit = vocabulary.bit(proposition)
            return None if bit & self._system.changing else bool(bit & self._system.constant)

        errands: list[tuple[_Reader, int]] = []
        parts = [
            _Part.of(restrictions.of(conjunct, constant), states)
            for conjunct, states in zip(problem.conjuncts, problem.automaton_states, strict=True)
        ]
        is_worth_it = sum(part.is_errand for part in parts) >= MIN_ERRANDS
        for part in parts:
            if part.accepts_all:
                continue
            reader = _Reader(part.automaton, marks, vocabulary)
            if part.is_errand and is_worth_it:
                errands.append((reader, part.states[0]))
            else:
                choices.append(part.states)
                self._readers.append(reader)
                marks += part.automaton.marks
        if math.prod(map(len, choices)) > max_edges:
            raise SearchLimit(f"no plan found: more than {max_edges} states to begin with")
        self.all_marks = (1 << marks) - 1
        self._joint: dict[tuple[int, tuple[int, ...]], list[tuple[tuple[int, ...], int]]] = {}
        facts = self._explore(
            [(self._system.start, states, 0) for states in itertools.product(*choices)], max_edges
        )
        self.errands = [
            [node for node, letter in enumerate(facts) if _is_over(reader, pending, letter)]
            for reader, pending in errands
        ]

    @property
    def nodes(self) -> int:
        """How many nodes there are."""
        return len(self.marks)

    def graph(self) -> csr_array:
        """Costs of the edges, as a sparse matrix from sources to targets."""
        shape = (self.nodes, self.nodes)
        return csr_array((self.costs.astype(float), self.targets, self.first), shape=shape)

    def edges(self, node: int) -> Iterator[tuple[int, int, int]]:
        """Target, cost and action of each edge that leaves a node."""
        span = slice(self.first[node], self.first[node + 1])
        return zip(
            self.targets[span].tolist(),
            self.costs[span].tolist(),
            self.actions[span].tolist(),
            strict=True,
        )

    def _explore(self, roots: list[Node], max_edges: int) -> list[int]:
        """Finds all nodes and edges; returns the facts of each node."""
        number_of = {node: number for number, node in enumerate(roots)}
        self.roots = list(range(len(roots)))
        todo = list(roots)
        first, targets, costs, actions = [0], [], [], []
        moves_of = self._system.moves
        for state, automata, _ in todo:  # grows while it is read
            cheapest: dict[int, tuple[int, int]] = {}
            for after, action, cost_ms in moves_of(state):
                for following, marks in self._read(after, automata, max_edges):
                    node = (after, following, marks)
                    number = number_of.get(node)
                    if number is None:
                        number = number_of[node] = len(todo)
                        todo.append(node)
                    known = cheapest.get(number)
                    if known is None or cost_ms < known[0]:
                        cheapest[number] = (cost_ms, action)
            for number, (cost_ms, action) in sorted(cheapest.items(), key=_by_action):
                targets.append(number)
                costs.append(cost_ms)
                actions.append(action)
            first.append(len(targets))
            if len(targets) > max_edges:
                raise SearchLimit(
                    f"no plan found among the first {max_edges} steps between product states"
                )
        self.marks = [marks for _, _, marks in todo]
        twins: dict[tuple[int, tuple[int, ...]], int] = {}
        self.twins = [twins.setdefault(node[:2], number) for number, node in enumerate(todo)]
        self.first = np.array(first, np.int32)
        self.targets = np.array(targets, np.int32)
        self.costs = np.array(costs, np.int64)
        self.actions = np.array(actions, np.int32)
        return [facts for facts, _, _ in todo]

    def _read(
        self, facts: int, states: tuple[int, ...], most: int
    ) -> list[tuple[tuple[int, ...], int]]:
        """All joint moves of the automata on the label of some facts, with their marks."""
        joint = self._joint.get((facts, states))
        if joint is None:
            joint = [((), 0)]
            for reader, state in zip(self._readers, states, strict=True):
                moves = reader.moves(state, facts)
                if len(joint) * len(moves) > most:
                    raise SearchLimit(f"no plan found: more than {most} runs of the automata")
                joint = [((*zs, z), marks | m) for zs, marks in joint for z, m in moves]
            self._joint[facts, states] = joint
        return joint


def _by_action(edge: tuple[int, tuple[int, int]]) -> int:
    return edge[1][1]


@dataclass(frozen=True, slots=True)
class _Part:
    """One conjunct under the constants, in the states that it may be in."""

    automaton: BuchiAutomaton
    states: list[int]
    accepts_all: bool
    is_errand: bool

    @classmethod
    def of(cls, restriction: Restriction, whole: frozenset[int]) -> _Part:
        states = restriction.states(whole)
        return cls(
            restriction.automaton,
            states,
            bool(restriction.everything.intersection(states)),
            len(states) == 1 and states[0] in restriction.one_shot_goals,
        )


class _Reader:
    """One automaton over bit masks; its marks are shifted to their place among all marks."""

    def __init__(self, automaton: BuchiAutomaton, first_mark: int, vocabulary: Vocabulary) -> None:
        self._outgoing = [
            [
                (
                    vocabulary.mask(t.label.positive),
                    vocabulary.mask(t.label.negative),
                    t.target,
                    sum(1 << first_mark + m for m in t.marks),
                )
                for t in transitions
            ]
            for transitions in automaton.outgoing
        ]

    def moves(self, state: int, facts: int) -> list[tuple[int, int]]:
        """Successor states and marks on reading some facts."""
        return list(
            dict.fromkeys(
                (target, marks)
                for positive, negative, target, marks in self._outgoing[state]
                if positive & facts == positive and not negative & facts
            )
        )


def _is_over(reader: _Reader, pending: int, facts: int) -> bool:
    """Whether an errand is done on reading some facts."""
    return any(target != pending for target, _ in reader.moves(pending, facts))
