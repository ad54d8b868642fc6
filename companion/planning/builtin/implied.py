"""Conjuncts that the others imply: they are left out of the product, which doubles with each line.

`G (at(A) -> F at(B))` says nothing beside `G F at(B)`: whatever the vehicle does, the one holds if
the other does. Whether that is so depends on what was read, and on the letters that there are. So
it is decided on the restricted automata, from their present states, over the facts that can be
reached: no run of the others may accept a word that the conjunct does not accept.

All states that the conjunct's automaton may be in are tracked at once (the breakpoint
construction). A breakpoint is reached when each tracked state has a run that met the mark since the
breakpoint before. If breakpoints recur for ever, one run meets the mark for ever (König's lemma).
So the answer "implied" is always right. The answer "not implied" may be too cautious where the
automaton is not deterministic, since some runs are given up: those that accept no word that the
others accept, those that another run stands for, and, if nothing is proved otherwise, all that have
not met a mark when one has. A conjunct that is not decided, or would take too long, is kept.

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
"""Edges after which it stays undecided whether a conjunct is implied."""
_EDGE_US = 4
_READING_US = 0.2
"""For each letter and automaton, whether it leads on or not."""
_READER_US = 40


class _Followed(NamedTuple):
    """Runs of an automaton: their states, those that met the mark, the number of the mark."""

    states: int
    met: int
    mark: int


_States = tuple[int, ...]
"""The states of one run of each of the others."""

T = TypeVar("T")


class Implications:
    """Which conjuncts are implied, kept from plan to plan."""

    def __init__(self) -> None:
        self._known: dict[tuple[object, ...], bool] = {}

    def without_implied(
        self,
        parts: Sequence[RestrictedConjunct],
        letters: Callable[[], Iterable[int] | None],
        bits: FactBits,
    ) -> list[RestrictedConjunct]:
        """The conjuncts without those that the rest of them implies, the largest ones first.

        One whose automaton has one state is kept, as it makes no product larger. So is one of
        which nothing has to come about, or nothing of those that it shares a proposition with.

        Args:
            parts: the conjuncts.
            letters: asked for the facts (bits) that words are made of; None if there are too many.
            bits: of the facts.
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
    """Those of the others that share a proposition with a conjunct."""
    read = frozenset(part.automaton.propositions)
    return [other for other in others if not read.isdisjoint(other.automaton.propositions)]


def is_implied(
    part: RestrictedConjunct,
    others: Sequence[RestrictedConjunct],
    letters: Sequence[int],
    bits: FactBits,
) -> bool:
    """Whether each word that all others accept is accepted; False if that is not decided.

    Args:
        part: a conjunct in its present states.
        others: conjuncts in theirs.
        letters: facts (bits) that words are made of.
        bits: of the facts.
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
    """There are too many edges."""


class _GivenUp(Enum):
    """The runs that are given up when some run has met a mark."""

    NONE = "none"
    BEHIND = "those that have not met it"


class _Joint:
    """The runs of all automata together on words of some letters; the last one is the conjunct's.

    Raises:
        _Undecided: there are too many.
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
        self._accepted = 1 << united.bit_length()  # a mark of its own: the conjunct met all its
        self._live = self._live_states(part, united)

    def _live_states(self, part: MaskedAutomaton, every_mark: int) -> dict[_States, int]:
        """The conjunct's states (bits) that accept a word which the others accept, by theirs."""
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
        """Whether each word that the others accept is found to be accepted by the runs."""
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
        """Targets and marks of the edges of each node, of which `pending` gets all.

        Args:
            pending: the first nodes: states of the others, and what is followed of the conjunct.
            step: what is followed, and marks, after reading a letter, given the others' new states.
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
    """The strong components, and whether each has a cycle with all marks."""
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
        """The runs one letter later, and whether the last of their marks was met.

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
        """The states without those of which another one accepts as much and met as much."""
        kept = states
        for state in indices(states):
            for other in indices(self._simulators[state] & kept & ~(1 << state)):
                if met >> other & 1 or not met >> state & 1:
                    kept &= ~(1 << state)
                    break
        return kept
