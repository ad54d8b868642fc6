"""The automata of a problem's conjuncts as the search reads them: restricted, over bit masks.

A run that repeats a move for ever may take it each time with other marks. So moves that differ only
in their marks are merged into one move with all of these marks; the same words are accepted.
"""

from __future__ import annotations

from dataclasses import dataclass

from companion.ltl.automaton import BuchiAutomaton
from companion.ltl.literals import Literals
from companion.ltl.restriction import Restriction
from companion.planning.builtin.fact_bits import FactBits
from companion.planning.lasso import Conjunct


@dataclass(frozen=True, slots=True)
class RestrictedConjunct:
    """A conjunct under the constants, in the states that its automaton may be in.

    Attributes:
        accepts_all: whether every word is accepted from one of the states.
        is_one_shot: whether the automaton waits to read a letter of some kind once.
        waiting_since_ms: since when the conjunct waits to be met again; None if nothing waits.
    """

    conjunct: Conjunct
    restriction: Restriction
    states: list[int]
    accepts_all: bool
    is_one_shot: bool
    waiting_since_ms: int | None

    @classmethod
    def of(
        cls,
        conjunct: Conjunct,
        restriction: Restriction,
        whole: frozenset[int],
        waiting_since_ms: int | None = None,
    ) -> RestrictedConjunct:
        """The conjunct, from the states that its whole automaton may be in."""
        states = restriction.states(whole)
        return cls(
            conjunct,
            restriction,
            states,
            bool(restriction.everything.intersection(states)),
            len(states) == 1 and states[0] in restriction.one_shot_goals,
            waiting_since_ms,
        )

    @property
    def automaton(self) -> BuchiAutomaton:
        """The restricted automaton."""
        return self.restriction.automaton

    @property
    def literals(self) -> Literals:
        """What the formula demands of the propositions that the restricted automaton reads."""
        positive, negative = self.conjunct.literals
        read = frozenset(self.automaton.propositions)
        return Literals(positive & read, negative & read)


class MaskedAutomaton:
    """An automaton over bit masks; its marks are shifted to their place among all marks.

    Attributes:
        states: number of states.
        every_mark: its marks, as bits.
    """

    def __init__(self, automaton: BuchiAutomaton, first_mark: int, bits: FactBits) -> None:
        self.states = automaton.states
        self.every_mark = ((1 << automaton.marks) - 1) << first_mark
        self._outgoing = [
            [
                (
                    bits.mask(t.label.positive),
                    bits.mask(t.label.negative),
                    t.target,
                    sum(1 << first_mark + m for m in t.marks),
                )
                for t in transitions
            ]
            for transitions in automaton.outgoing
        ]
        self._read = bits.mask(automaton.propositions)
        self._successors: dict[tuple[int, int], list[tuple[int, int]]] = {}

    def successors(self, state: int, facts: int) -> list[tuple[int, int]]:
        """Successor states and marks after reading some facts."""
        key = (state, facts & self._read)
        found = self._successors.get(key)
        if found is None:
            found = self._successors[key] = self._reading(*key)
        return found

    def _reading(self, state: int, facts: int) -> list[tuple[int, int]]:
        found: dict[int, int] = {}
        for positive, negative, after, marks in self._outgoing[state]:
            if positive & facts == positive and not negative & facts:
                found[after] = found.get(after, 0) | marks
        return list(found.items())

    def awaited(self, state: int) -> int:
        """The only fact (a bit) that leads from a state to another; 0 unless it is exactly one."""
        leaving = [(p, n) for p, n, after, _ in self._outgoing[state] if after != state]
        if len(leaving) != 1:
            return 0
        ((positive, negative),) = leaving
        return positive if positive.bit_count() == 1 and not negative else 0

    def leaves(self, state: int, facts: int) -> bool:
        """Whether reading some facts leads from a state to another one."""
        return any(after != state for after, _ in self.successors(state, facts))
