"""Caches a mission's automata under the constants that the search has met."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from companion.ltl.restriction import Restriction, restricted
from companion.planning.builtin.fact_bits import FactBits
from companion.planning.builtin.implied import Implications
from companion.planning.builtin.lap_profiles import LapProfiles
from companion.planning.builtin.masked_automaton import MaskedAutomaton, RestrictedConjunct
from companion.planning.lasso import Conjunct
from companion.slices import spent

_LOOKING_US = 20
_RESTRICTING_US = 300
_MASKING_US = 60


class Restrictions:
    """The conjuncts' automata under constants, kept from plan to plan.

    Attributes:
        implications: which of these conjuncts imply others.
    """

    def __init__(self) -> None:
        self._found: dict[tuple[int, tuple[bool | None, ...]], tuple[Conjunct, Restriction]] = {}
        self._masked: dict[tuple[int, int], MaskedAutomaton] = {}
        self._max_laps: dict[tuple[int, frozenset[int]], int] = {}
        self.implications = Implications()

    def masked(self, part: RestrictedConjunct, first_mark: int, bits: FactBits) -> MaskedAutomaton:
        """A conjunct's automaton over bit masks.

        Args:
            part: the conjunct.
            first_mark: the number of its first mark among all marks.
            bits: the bits of the facts; always the same ones.
        """
        key = (id(part.restriction), first_mark)
        found = self._masked.get(key)
        if found is None:
            spent(_MASKING_US)
            found = self._masked[key] = MaskedAutomaton(part.automaton, first_mark, bits)
        return found

    def max_laps(self, part: RestrictedConjunct, letters: Iterable[int], bits: FactBits) -> int:
        """The most laps of actions that a cycle of a conjunct's automaton takes.

        Args:
            part: the conjunct.
            letters: the facts (bits) that laps are made of.
            bits: the bits of the facts.
        """
        mask = bits.mask(part.automaton.propositions)
        read = frozenset(letter & mask for letter in letters)
        key = (id(part.restriction), read)
        if key not in self._max_laps:
            profiles = LapProfiles(self.masked(part, 0, bits))
            self._max_laps[key] = profiles.max_laps(sorted(read))
        return self._max_laps[key]

    def of(self, conjunct: Conjunct, constants: Callable[[str], bool | None]) -> Restriction:
        """A conjunct's automaton, given the values of propositions; None for those that change."""
        names = conjunct.automaton.propositions
        spent(_LOOKING_US)
        values = tuple(map(constants, names))
        key = (id(conjunct), values)
        found = self._found.get(key)
        if found is None:
            spent(_RESTRICTING_US)
            fixed = {n: v for n, v in zip(names, values, strict=True) if v is not None}
            found = (conjunct, restricted(conjunct.automaton, fixed))
            self._found[key] = found  # keeping the conjunct alive keeps its identity unique
        return found[1]
