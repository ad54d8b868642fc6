"""Lines of a task with a time bound, as clocks that read a word.

A bound is pointwise: it is about the positions of a word and the times at which they are reached.
Each kind of bound is one clock, a deterministic automaton with one stop watch:

- `F[<=T] p`: the clock runs from the first position until p holds.
- `G (a -> F[<=T] p)`: the clock starts where a holds and p does not, unless it already runs, and
  stops at p.
- `revisit(p) <= T`: the clock always runs, and is reset to 0 where p holds. That is not `G F[<=T]
  p`: p holds at p itself, so the leg that leaves it would not be counted.

Without its bound each line is an ordinary formula, `untimed`, which an automaton reads. So a clock
only has to refuse what comes too late.

Source: Koymans, Specifying real-time properties with metric temporal logic, Real-Time Systems 1990
(pointwise semantics); Alur and Dill, A theory of timed automata, TCS 1994.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

from companion.ltl.formula import Formula, Operator, always, eventually, implies, operand_text

MARGIN_MS = 2000
MARGIN_PERCENT = 5
"""The margin that plans keep, because flights take longer than planned."""


@dataclass(frozen=True)
class TimeBound(ABC):
    """A line with a time bound.

    Attributes:
        goal: what has to come in time; without temporal operators.
        limit_ms: the time limit in milliseconds.
    """

    goal: Formula
    limit_ms: int

    @property
    @abstractmethod
    def untimed(self) -> Formula:
        """The line without its bound."""

    @property
    def planned_ms(self) -> int:
        """The limit that plans keep: shorter by 5 %, or by 2 s if that is more.

        >>> from companion.ltl.parser import atom
        >>> [Within(atom("p"), limit).planned_ms for limit in (10_000, 60_000)]
        [8000, 57000]
        """
        less_ms = self.limit_ms * (100 - MARGIN_PERCENT) // 100
        return min(less_ms, self.limit_ms - MARGIN_MS)

    @property
    def watched_ms(self) -> int:
        """The limit for an action under way that takes longer than planned: half of the margin is
        left for another plan.

        >>> from companion.ltl.parser import atom
        >>> Within(atom("p"), 60_000).watched_ms
        58500
        """
        return (self.planned_ms + self.limit_ms) // 2

    @property
    def _limit_s(self) -> str:
        return f"{self.limit_ms / 1000:.3f}".rstrip("0").rstrip(".")

    @property
    def _within(self) -> str:
        """`F[<=T] goal`."""
        return f"F[<={self._limit_s}s] {operand_text(self.goal, Operator.EVENTUALLY)}"

    @abstractmethod
    def begin(self) -> int | None:
        """The clock before the first position: 0 if it runs from there on."""

    @abstractmethod
    def after(self, elapsed_ms: int | None, is_true: Callable[[Formula], bool]) -> int | None:
        """The clock after a position is read.

        Args:
            elapsed_ms: what it showed when the position was reached; None if it stood still.
            is_true: whether a formula without temporal operators holds at the position.
        """

    def is_late(self, elapsed_ms: int | None) -> bool:
        """Whether a clock that shows this at an unread position has run out."""
        return elapsed_ms is not None and elapsed_ms > self.limit_ms


@dataclass(frozen=True)
class Within(TimeBound):
    """`F[<=T] goal`, from the first position on."""

    def __str__(self) -> str:
        return self._within

    @property
    def untimed(self) -> Formula:
        """The line without its bound."""
        return eventually(self.goal)

    def begin(self) -> int | None:
        """The clock before the first position."""
        return 0

    def after(self, elapsed_ms: int | None, is_true: Callable[[Formula], bool]) -> int | None:
        """The clock after a position is read."""
        return None if is_true(self.goal) else elapsed_ms


@dataclass(frozen=True)
class Response(TimeBound):
    """`G (trigger -> F[<=T] goal)`.

    Attributes:
        trigger: what asks for the goal; without temporal operators.
    """

    trigger: Formula

    def __str__(self) -> str:
        return f"G({operand_text(self.trigger, Operator.IMPLIES)} -> {self._within})"

    @property
    def untimed(self) -> Formula:
        """The line without its bound."""
        return always(implies(self.trigger, eventually(self.goal)))

    def begin(self) -> int | None:
        """The clock before the first position."""
        return None

    def after(self, elapsed_ms: int | None, is_true: Callable[[Formula], bool]) -> int | None:
        """The clock after a position is read."""
        if is_true(self.goal):
            return None
        return 0 if elapsed_ms is None and is_true(self.trigger) else elapsed_ms


@dataclass(frozen=True)
class Revisit(TimeBound):
    """`revisit(goal) <= T`: between positions with the goal, and from the start to the first."""

    def __str__(self) -> str:
        goal = str(self.goal)
        if place := re.fullmatch(r"at\((\w+)\)", goal):
            goal = place[1]
        elif not self.goal.operands:  # a name alone is that of a place
            goal = f"({goal})"
        return f"revisit({goal}) <= {self._limit_s} s"

    @property
    def untimed(self) -> Formula:
        """The line without its bound."""
        return always(eventually(self.goal))

    def begin(self) -> int | None:
        """The clock before the first position."""
        return 0

    def after(self, elapsed_ms: int | None, is_true: Callable[[Formula], bool]) -> int | None:
        """The clock after a position is read."""
        return 0 if is_true(self.goal) else elapsed_ms
