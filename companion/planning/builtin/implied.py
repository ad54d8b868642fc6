"""Conjuncts that the others imply; they are left out of the product, which grows with each.

`G (at(A) -> F at(B))` is redundant beside `G F at(B)`: whatever the vehicle does, it holds if the
other does. Whether a conjunct is redundant depends on what was read, and on which letters are
possible. So the decision uses the restricted automata, from their present states, over the facts
that can be reached: no run of the others may accept a word that the conjunct does not accept.

All possible states of the conjunct's automaton are tracked at once (the breakpoint construction). A
breakpoint is reached when each tracked state has a run that has met the mark since the last
breakpoint. If breakpoints recur for ever, one run meets the mark for ever (König's lemma). So the
answer "implied" is always right. The answer "not implied" may be too cautious if the automaton is
not deterministic, because some runs are dropped: those that accept no word that the others accept,
those that another run simulates, and, as a last attempt, all that have not met a mark when one has.
A conjunct is kept if the question stays open or would take too long.

Source: Miyano and Hayashi, Alternating finite automata on omega-words, 1984, for breakpoints.
"""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from enum import Enum
from functools import reduce
from operator import or_
from typing import NamedTuple, TypeVar

from companion.ltl.bitsets import indices
from companion.ltl.components import reaching, strong_components
from companion.planning.builtin.fact_bits import FactBits
from companion.planning.builtin.masked_automaton import MaskedAutomaton, RestrictedConjunct
from companion.slices import spent

MAX_EDGES = 5_000
"""The most edges that are examined before the question stays open."""
_EDGE_US = 4
_READING_US = 0.2
"""Time, for each letter and automaton, to find out whether it can be read."""
_READER_US = 40


class _Followed(NamedTuple):
    """Runs of an automaton: their states, those that met the mark, and the number of the mark."""

    states: int
    met: int
    mark: int


_States = tuple[int, ...]
"""The states of one run of each of the other automata."""

T = TypeVar("T")


class Implications:
    """Which conjuncts are implied; results are kept from plan to plan."""

    def __init__(self) -> None:
        self._known: dict[tuple[object, ...], bool] = {}

    def without_implied(
        self,
        parts: Sequence[RestrictedConjunct],
        letters: Callable[[], Iterable[int] | None],
        bits: FactBits,
    ) -> list[RestrictedConjunct]:
        """The conjuncts without those that the rest of them implies, the largest first.

        A conjunct is kept if its automaton has one state, because it enlarges no product. It is
        also kept if its automaton has no marks, or if no conjunct that shares a proposition with it
        has any.

        Args:
            parts: the conjuncts.
            letters: returns the facts (bits) that words are made of; None if there are too many.
            bits: the bits of the facts.
        """
        kept = list(parts)
        seen: set[int] | None = None
        large = [part for part in parts if part.automaton.states > 1 and part.automaton.marks]
        for part in sorted(large, key=lambda part: -part.automaton.states):
            others = [p for p in kept if p is not part]
            related = _related(part, others)
            if not any(p.automaton.marks for p in related):
                continue
            if seen is None:
                found = letters()
                if found is None:
                    return kept
                seen = set(found)
            if self._is_implied(part, related, seen, bits):
                kept = others
        return kept

    def _is_implied(
        self,
        part: RestrictedConjunct,
        related: list[RestrictedConjunct],
        letters: set[int],
        bits: FactBits,
    ) -> bool:
        named = {name for p in (part, *related) for name in p.automaton.propositions}
        mask = bits.mask(named)
        seen = frozenset(letter & mask for letter in letters)
        key = (seen, *((id(p.restriction), *p.states) for p in (part, *related)))
        if key not in self._known:
            self._known[key] = is_implied(part, related, sorted(seen), bits)
        return self._known[key]


def _related(
    part: RestrictedConjunct, others: list[RestrictedConjunct]
) -> list[RestrictedConjunct]:
    """The other conjuncts that share a proposition with this one."""
    read = frozenset(part.automaton.propositions)
    return [other for other in others if not read.isdisjoint(other.automaton.propositions)]


def is_implied(
    part: RestrictedConjunct,
    others: Sequence[RestrictedConjunct],
    letters: Sequence[int],
    bits: FactBits,
) -> bool:
    """Whether it accepts each word that all others accept; False if that stays open.

    Args:
        part: a conjunct in its present states.
        others: the other conjuncts in their present states.
        letters: the facts (bits) that words are made of.
        bits: the bits of the facts.
    """
    readers: list[MaskedAutomaton] = []
    marks = 0
    for each in (*others, part):
        spent(_READER_US)
        readers.append(MaskedAutomaton(each.automaton, marks, bits))
        marks += each.automaton.marks
    try:
        joint = _Joint(readers, [*(other.states for other in others), part.states], letters)
        return any(joint.includes(_Runs(part, bits, given_up)) for given_up in _GivenUp)
    except _Undecided:
        return False


class _Undecided(Exception):
    """There are too many edges to decide."""


class _GivenUp(Enum):
    """Which runs are dropped when some run has met a mark."""

    NONE = "none"
    BEHIND = "those that have not met it"


class _Joint:
    """The runs of all automata together on words of some letters; the conjunct's is the last.

    Raises:
        _Undecided: there are too many edges.
    """

    def __init__(
        self, readers: list[MaskedAutomaton], states: list[list[int]], letters: Sequence[int]
    ) -> None:
        *self._others, part = readers
        self._letters = letters
        self._reading_us = _READING_US * len(letters) * len(readers)
        if math.prod(map(len, states)) > MAX_EDGES:
            raise _Undecided
        self._begin = list(itertools.product(*states[:-1]))
        self._part_begin = states[-1]
        self._edges_left = MAX_EDGES
        united = sum(reader.every_mark for reader in readers)
        self._every_mark = united & ~part.every_mark
        self._accepted = 1 << united.bit_length()  # an extra mark: the conjunct met all its own
        self._live = self._live_states(part, united)

    def _live_states(self, part: MaskedAutomaton, every_mark: int) -> dict[_States, int]:
        """By states of the others: the conjunct's states (bits) that accept a word of theirs."""
        pending = [(z, own) for z in self._begin for own in self._part_begin]
        edges = self._explored(
            pending,
            lambda own, _, letter: part.successors(own, letter),
        )
        components, accepting = _components(edges, every_mark)
        live: dict[_States, int] = defaultdict(int)
        for number in reaching([[t for t, _ in row] for row in edges], components, accepting):
            states, own = pending[number]
            live[states] |= 1 << own
        return live

    def includes(self, runs: _Runs) -> bool:
        """Whether the runs are found to accept each word that the others accept."""
        begin = sum(1 << state for state in self._part_begin)
        pending = [(z, _Followed(begin & self._live.get(z, 0), 0, 0)) for z in self._begin]

        def step(own: _Followed, states: _States, letter: int) -> list[tuple[_Followed, int]]:
            after, is_last = runs.after(own, letter, self._live.get(states, 0))
            return [(after, self._accepted * is_last)]

        edges = self._explored(pending, step)
        rejecting = [[(end, met) for end, met in row if not met & self._accepted] for row in edges]
        return not any(_components(rejecting, self._every_mark)[1])

    def _explored(
        self,
        pending: list[tuple[_States, T]],
        step: Callable[[T, _States, int], Iterable[tuple[T, int]]],
    ) -> list[list[tuple[int, int]]]:
        """Targets and marks of the edges of each node; all nodes are added to `pending`.

        Args:
            pending: the first nodes: states of the others, and what is followed of the conjunct.
            step: from what is followed, a letter and the others' new states, what is followed next
                and the marks.
        """
        number_of = {node: number for number, node in enumerate(pending)}
        edges: list[list[tuple[int, int]]] = []
        for states, own in pending:  # grows while it is read
            edges.append([])
            for letter in self._letters:
                moves = [r.successors(z, letter) for r, z in zip(self._others, states, strict=True)]
                if math.prod(map(len, moves)) > self._edges_left:
                    raise _Undecided
                for move in itertools.product(*moves):
                    targets = tuple(target for target, _ in move)
                    met = sum(marks for _, marks in move)
                    for after, marks in step(own, targets, letter):
                        number = number_of.setdefault((targets, after), len(pending))
                        if number == len(pending):
                            pending.append((targets, after))
                        edges[-1].append((number, met | marks))
            self._edges_left -= len(edges[-1])
            spent(_EDGE_US * len(edges[-1]) + self._reading_us)
            if self._edges_left < 0:
                raise _Undecided
        return edges


def _components(
    edges: list[list[tuple[int, int]]], every_mark: int
) -> tuple[list[list[int]], list[bool]]:
    """The strong components, and whether each has a cycle that meets all marks."""
    components = strong_components([[end for end, _ in leaving] for leaving in edges])
    accepting = []
    for component in components:
        inside = set(component)
        met = [marks for node in component for end, marks in edges[node] if end in inside]
        accepting.append(bool(met) and reduce(or_, met) & every_mark == every_mark)
    return components, accepting


class _Runs:
    """All runs of a conjunct's automaton, followed together."""

    def __init__(self, part: RestrictedConjunct, bits: FactBits, given_up: _GivenUp) -> None:
        self._automaton = MaskedAutomaton(part.automaton, 0, bits)
        self._marks = part.automaton.marks
        self._simulators = part.restriction.simulators
        self._given_up = given_up

    def after(self, followed: _Followed, letter: int, live: int) -> tuple[_Followed, bool]:
        """The runs one letter later, and whether they met the last of their marks.

        Args:
            live: the states that may be followed.
        """
        reached = met = 0
        for state in indices(followed.states):
            for after, marks in self._automaton.successors(state, letter):
                reached |= 1 << after
                if not self._marks or followed.met >> state & 1 or marks >> followed.mark & 1:
                    met |= 1 << after
        if self._given_up is _GivenUp.BEHIND and met & live:
            reached &= met
        reached = self._without_simulated(reached & live, met)
        met &= reached
        if not reached or met != reached:
            return _Followed(reached, met, followed.mark), False
        is_last = followed.mark + 1 >= self._marks
        return _Followed(reached, 0, 0 if is_last else followed.mark + 1), is_last

    def _without_simulated(self, states: int, met: int) -> int:
        """The states without those of which another one accepts as much and has met as much."""
        kept = states
        for state in indices(states):
            for other in indices(self._simulators[state] & kept & ~(1 << state)):
                if met >> other & 1 or not met >> state & 1:
                    kept &= ~(1 << state)
                    break
        return kept
