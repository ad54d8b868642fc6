"""Lines of a task in which some parts have a time bound.

All parts have to hold. A line without any bound is a plain formula.

>>> from companion.ltl.parser import parse_line
>>> line = parse_line("F[<= 1 min] at(A) & G F at(B)")
>>> str(line), str(untimed(line)), [str(part) for part, _ in parts(line)]
('F[<=60s] at(A) & G F at(B)', 'F at(A) & G F at(B)', ['F at(A)', 'G F at(B)'])
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from companion.ltl.conjuncts import conjuncts
from companion.ltl.formula import Formula, Operator, conjoin, operand_text
from companion.ltl.time_bounds import TimeBound


@dataclass(frozen=True)
class TimedFormula:
    """A conjunction of formulas and time bounds, with at least one bound."""

    parts: tuple[Formula | TimeBound, ...]

    def __str__(self) -> str:
        """The line in a form that `parse_line` can read."""
        return " & ".join(
            operand_text(part, Operator.AND) if isinstance(part, Formula) else str(part)
            for part in self.parts
        )


Line = Formula | TimedFormula
"""What a line of a task stands for."""


def parts(line: Line) -> Iterator[tuple[Formula, TimeBound | None]]:
    """The conjuncts of a line as formulas, each with its bound, if it has one."""
    for part in (line,) if isinstance(line, Formula) else line.parts:
        if isinstance(part, TimeBound):
            yield part.untimed, part
        else:
            yield from ((conjunct, None) for conjunct in conjuncts(part))


def untimed(line: Line) -> Formula:
    """A line without its time bounds."""
    if isinstance(line, Formula):
        return line
    return conjoin(*(p.untimed if isinstance(p, TimeBound) else p for p in line.parts))
