"""Facts as bits, so that a set of facts is an int."""

from __future__ import annotations

from collections.abc import Collection

from companion.mission.facts import Fact


class FactBits:
    """Assigns a bit to each fact, in the order in which they are asked for.

    >>> bits = FactBits()
    >>> bits.mask({"at(A)", "lit"}), bits.mask({"lit"})
    (3, 2)
    >>> sorted(bits.facts(3))
    ['at(A)', 'lit']
    """

    def __init__(self) -> None:
        self._bit: dict[str, int] = {}  # by proposition

    def mask(self, propositions: Collection[str]) -> int:
        """The bits of some facts, or of the propositions of an automaton's label."""
        bits = 0
        for proposition in sorted(propositions) if propositions else ():  # sets have no order
            bits |= self.bit(proposition)
        return bits

    def bit(self, proposition: str) -> int:
        """The bit of a fact, which may be given as a proposition."""
        bit = self._bit.get(proposition)
        if bit is None:
            bit = self._bit[proposition] = 1 << len(self._bit)
        return bit

    def facts(self, mask: int) -> frozenset[Fact]:
        """The facts whose bits are in a mask."""
        return frozenset(Fact.parse(p) for p, bit in self._bit.items() if bit & mask)
