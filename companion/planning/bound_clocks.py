"""What the clocks of bounded conjuncts show at a position of the word."""

from __future__ import annotations

from collections.abc import Sequence

from companion.ltl.formula import Formula
from companion.ltl.semantics import holds
from companion.ltl.time_bounds import TimeBound
from companion.planning.lasso import Conjunct, Letter


def after(bound: TimeBound, elapsed_ms: int | None, letter: Letter) -> int | None:
    """The clock of a bound once a position was read."""

    def is_true(formula: Formula) -> bool:
        return holds(formula, (), (letter,))

    return bound.after(elapsed_ms, is_true)


def begun(conjuncts: Sequence[Conjunct], letter: Letter) -> tuple[int | None, ...]:
    """The clocks after the first position, as problems have them; () if none has a bound."""
    bounds = [conjunct.bound for conjunct in conjuncts]
    if not any(bounds):
        return ()
    return tuple(after(b, b.begin(), letter) if b is not None else None for b in bounds)
