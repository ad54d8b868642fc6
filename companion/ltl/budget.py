"""Limits for the cost of a translation; they are named, and the same formula always costs the same.

The automaton of a one-line formula can fill any machine. So a translation spends from a budget:
elementary *steps*, which stand for time, and *bytes* that are kept until the end. Both are counted
instead of measured, so whether a formula can be translated does not depend on the machine.

A step is one pass of an inner loop, e.g. one union of two bit sets, about 0.25 us. Ints of
thousands of bits cost more, in proportion to their width:

- before a loop, or before each pass of an outer one, call `spend(passes, width)`, so that an
  exhausted budget is noticed before the loop runs;
- call `keep(sets, width)` for what stays until the end: terms in a cache, edges, relations. What
  one step makes and drops again need not be counted if something else limits it.

Making an automaton smaller is optional work. It spends from parts of the budget's *spare* steps
(`spared`); when such a part is spent, the automaton stays as it is.

With the defaults no formula takes more than a few seconds and 512 MB for the whole process. A
formula that is split into conjuncts has one budget for all of them.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from companion.errors import KeyPath, Location, MissionError
from companion.slices import spent

STEPS = 40_000_000
BYTES = 200_000_000
SPARE_STEPS = 40_000_000

_STEP_US = 0.25

_BITS_A_STEP = 1024
"""An operation on ints of this width costs one step more than one on small ints."""

_BYTES_A_SET = 128
"""Memory for a small int and its place in a list or set, or for an edge."""


_SHORTEN = "write it with fewer operators or propositions"
_SPLIT = "split the task into conjuncts: each of them gets its own automaton"


class TranslationLimit(MissionError):
    """The automaton of a formula would be too large, or would take too long to find.

    Args:
        limit: the limit that would be exceeded, e.g. `10,000 states`.
        where: the place of the formula in a file, once the caller knows it.
        advice: what to do about it.
    """

    def __init__(
        self, limit: str, where: Location | KeyPath | None = None, advice: str = _SHORTEN
    ) -> None:
        self.limit = limit
        self.advice = advice
        super().__init__(f"the automaton would take more than {limit}", where, advice)

    def located(self, where: Location | KeyPath) -> TranslationLimit:
        """The same error with its place in a file or in data."""
        return TranslationLimit(self.limit, where, self.advice)

    def after_others(self, share: float) -> TranslationLimit:
        """The same error if other lines have already spent a share of the budget."""
        shared = f"{self.limit}, which all lines of the task share"
        advice = f"the lines before it take {100 * share:.0f} %: write fewer or shorter ones"
        return TranslationLimit(shared, self.where, advice)

    def for_conjunction(self) -> TranslationLimit:
        """The same error for a formula that can be split."""
        return TranslationLimit(self.limit, advice=_SPLIT)


@dataclass(slots=True)
class Budget:
    """A budget for one formula, in steps and bytes.

    >>> budget = Budget(steps=1000)
    >>> budget.spend(900)
    >>> budget.spend(1, width=200_000)
    Traceback (most recent call last):
    companion.ltl.budget.TranslationLimit: the automaton would take more than 1,000 steps of work
        write it with fewer operators or propositions

    Attributes:
        steps: number of elementary steps that are allowed.
        kept_bytes: approximate number of bytes that are allowed.
        spare_steps: number of steps left for optional work.
    """

    steps: int = STEPS
    kept_bytes: int = BYTES
    spare_steps: int = SPARE_STEPS
    _spent: int = field(default=0, init=False)
    _kept: int = field(default=0, init=False)

    @property
    def share(self) -> float:
        """The spent share, the higher of steps and bytes; above 1 if the budget fell short."""
        return max(self._spent / self.steps, self._kept / self.kept_bytes)

    @classmethod
    def of_a_mission(cls) -> Budget:
        """A budget for all lines of a task together: about 6 s and 200 MB."""
        return cls(steps=16_000_000, spare_steps=8_000_000)

    @classmethod
    def unlimited(cls) -> Budget:
        """A budget that never runs out."""
        return cls(sys.maxsize, sys.maxsize)

    @contextmanager
    def spared(self, steps: int, kept_bytes: int = BYTES) -> Iterator[Budget]:
        """A budget for optional work: at most these steps, taken from the spare ones.

        >>> budget = Budget(spare_steps=1000)
        >>> with budget.spared(300) as spare:
        ...     spare.spend(200)
        >>> budget.spare_steps
        800
        """
        part = Budget(min(steps, self.spare_steps), kept_bytes, 0)
        try:
            yield part
        finally:
            self.spare_steps -= min(part._spent, part.steps)

    def spend(self, passes: int, width: int = 0) -> None:
        """Spends steps for passes of a loop over ints of `width` bits.

        Raises:
            TranslationLimit: too few steps are left.
        """
        steps = passes * (1 + width // _BITS_A_STEP)
        spent(_STEP_US * steps)
        self._spent += steps
        if self._spent > self.steps:
            raise TranslationLimit(f"{self.steps:,} steps of work")

    def keep(self, sets: int, width: int = 0) -> None:
        """Spends memory for as many sets of `width` bits, or as many edges with such labels.

        Raises:
            TranslationLimit: too little memory is left.
        """
        self._kept += sets * (_BYTES_A_SET + width // 7)  # an int has 7.5 bits a byte
        if self._kept > self.kept_bytes:
            raise TranslationLimit(f"{self.kept_bytes // 1_000_000:,} MB of memory")
