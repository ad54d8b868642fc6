"""The product of the task model and the automata, built only where the search goes.

A node is a set of facts together with one state per automaton (Section III-A):

    s -> s'  and  z_i --L(s')--> z_i'  for every i   gives   (s, z) -> (s', z')

The automata have read the position they are at (see `lasso.py`). A nondeterministic automaton makes
several edges, so a path through the product fixes one run of each. Acceptance stays generalized
and on the edges: bit m of an edge's marks is set if it belongs to acceptance set m.

Facts and labels are bit masks here, and nowhere else.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import NamedTuple

from companion.errors import NoPlanError
from companion.ltl.automaton import BuchiAutomaton
from companion.planning.domain import Action
from companion.planning.lasso import Problem

MAX_NODES = 200_000
"""Nodes after which the search gives up; bounds its time (about 10 us a node) and memory."""


class SearchLimit(NoPlanError):
    """The search was given up at its limit; there may be a plan."""


class Edge(NamedTuple):
    """One step of the product."""

    target: int
    action: int  # index into Problem.actions
    cost_ms: int
    marks: int


@dataclass(frozen=True, slots=True)
class _Step:
    """An action over bit masks."""

    index: int
    requires: int
    forbids: int
    adds: int
    keeps: int
    cost_ms: int


class Product:
    """The reachable product of a problem.

    Attributes:
        edges: outgoing edges per node, in the order of the problem's actions.
        roots: nodes at which a plan may begin.
        all_marks: the marks that a loop has to meet.
    """

    def __init__(self, problem: Problem) -> None:
        self._bit: dict[str, int] = {}
        self._steps = [self._step(i, action) for i, action in enumerate(problem.actions)]
        self._readers: list[_Reader] = []
        marks = 0
        for conjunct in problem.conjuncts:
            self._readers.append(_Reader(conjunct.automaton, marks, self))
            marks += conjunct.automaton.marks
        self.all_marks = (1 << marks) - 1
        self.edges: list[list[Edge]] = []
        self._ids: dict[tuple[int, tuple[int, ...]], int] = {}
        self._moves: dict[int, list[tuple[int, int, int]]] = {}
        self._todo: list[tuple[int, tuple[int, ...]]] = []
        facts = self.mask(problem.facts)
        self.roots = [
            self._node(facts, states)
            for states in itertools.product(*map(sorted, problem.automaton_states))
        ]
        self._build()

    def mask(self, facts: frozenset[str]) -> int:
        """The bits of a set of facts."""
        bits = 0
        for fact in sorted(facts):
            bits |= self._bit.setdefault(fact, 1 << len(self._bit))
        return bits

    def _step(self, index: int, action: Action) -> _Step:
        return _Step(
            index=index,
            requires=self.mask(action.requires),
            forbids=self.mask(action.forbids),
            adds=self.mask(action.adds),
            keeps=~self.mask(action.deletes),
            cost_ms=action.cost_ms,
        )

    def _node(self, facts: int, states: tuple[int, ...]) -> int:
        key = (facts, states)
        node = self._ids.get(key)
        if node is None:
            node = self._ids[key] = len(self._ids)
            if node >= MAX_NODES:
                raise SearchLimit(f"no plan found among the first {MAX_NODES} product states")
            self._todo.append(key)
        return node

    def _build(self) -> None:
        done = 0
        while done < len(self._todo):
            facts, states = self._todo[done]
            done += 1
            self.edges.append(
                [
                    Edge(self._node(after, next_states), action, cost_ms, marks)
                    for after, action, cost_ms in self._moves_from(facts)
                    for next_states, marks in self._read(after, states)
                ]
            )

    def _read(self, facts: int, states: tuple[int, ...]) -> list[tuple[tuple[int, ...], int]]:
        """All joint moves of the automata on the label of some facts, with their marks."""
        joint: list[tuple[tuple[int, ...], int]] = [((), 0)]
        for reader, state in zip(self._readers, states, strict=True):
            moves = reader.moves(state, facts)
            joint = [((*zs, z), marks | m) for zs, marks in joint for z, m in moves]
        return joint

    def _moves_from(self, facts: int) -> list[tuple[int, int, int]]:
        """Facts afterwards, action and cost of every applicable action."""
        moves = self._moves.get(facts)
        if moves is None:
            moves = self._moves[facts] = [
                (facts & step.keeps | step.adds, step.index, step.cost_ms)
                for step in self._steps
                if step.requires & facts == step.requires and not step.forbids & facts
            ]
        return moves


class _Reader:
    """One automaton over bit masks; its marks are shifted to their place among all marks."""

    def __init__(self, automaton: BuchiAutomaton, first_mark: int, product: Product) -> None:
        self._outgoing = [
            [
                (
                    product.mask(t.label.positive),
                    product.mask(t.label.negative),
                    t.target,
                    sum(1 << first_mark + m for m in t.marks),
                )
                for t in transitions
            ]
            for transitions in automaton.outgoing
        ]
        self._cache: dict[tuple[int, int], list[tuple[int, int]]] = {}

    def moves(self, state: int, facts: int) -> list[tuple[int, int]]:
        """Successor states and marks on reading some facts."""
        found = self._cache.get((state, facts))
        if found is None:
            found = self._cache[state, facts] = list(
                dict.fromkeys(
                    (target, marks)
                    for positive, negative, target, marks in self._outgoing[state]
                    if positive & facts == positive and not negative & facts
                )
            )
        return found
