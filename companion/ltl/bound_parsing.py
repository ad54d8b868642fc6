"""Time bounds during parsing: what they mean, and where they may occur.

A bound occurs at `F`, at `revisit(...)`, or at the F of `G (... -> F ...)`; each of these is a
conjunct of the whole text. Elsewhere a bound would not be one clock: below X or ! no position says
when the clock starts or stops, and in a disjunction it may be unclear whether anybody still waits.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from lark import Token

from companion.grammars import error_at
from companion.ltl.formula import TEMPORAL, Formula, conjoin, implies, subformulas
from companion.ltl.time_bounds import Response, Revisit, TimeBound, Within
from companion.ltl.timed_formula import TimedFormula

MIN_LIMIT_S = 3.0
"""The shortest limit, because a plan keeps a margin of 2 s."""
MAX_LIMIT_S = 86_400.0
UNITS_S = {"s": 1.0, "min": 60.0}

_LIMIT = re.compile(r"(?P<sign>\D*?)\s*(?P<number>[-+]?\d+(\.\d+)?)\s*(?P<unit>[A-Za-z]*)")
_WRITE = {"BOUND": "write F[<=60s] at(A)", "LIMIT": "write revisit(A) <= 120 s"}


@dataclass(frozen=True, slots=True)
class TimedParts:
    """Parts that all have to hold; some have a bound, and one of these is at the token `bound`."""

    parts: tuple[Formula | TimeBound, ...]
    bound: Token


@dataclass(frozen=True, slots=True)
class TimedAnswer:
    """`trigger -> F[<=T] goal`, which has a meaning only below G."""

    trigger: Formula
    within: Within
    bound: Token


Parsed = Formula | TimedParts | TimedAnswer
"""What a part of a text stands for."""


def within(bound: Token, goal: Parsed) -> TimedParts:
    """`F[<=T] goal`."""
    return TimedParts((Within(_state_formula(goal, bound), _limit_ms(bound, bound[1:-1])),), bound)


def revisit(name: Token, goal: Parsed, limit: Token | None) -> TimedParts:
    """`revisit(goal) <= T`."""
    if limit is None:
        what = "revisit has no bound: within what time, again and again?"
        raise error_at(name, what, f"{_WRITE['LIMIT']}; without a bound it is G F at(A)")
    goal = _state_formula(goal, limit)
    return TimedParts((Revisit(goal, _limit_ms(limit, limit)),), limit)


def implication(left: Parsed, right: Parsed) -> Parsed:
    """`left -> right`; if it has a bound, it needs a G above it."""
    match right:
        case TimedParts(parts=(Within() as within,), bound=bound):
            return TimedAnswer(_state_formula(left, bound), within, bound)
    return implies(without_bounds(left), without_bounds(right))


def response(found: TimedAnswer) -> TimedParts:
    """`G (trigger -> F[<=T] goal)`."""
    within = found.within
    return TimedParts((Response(within.goal, within.limit_ms, found.trigger),), found.bound)


def conjunction(operands: tuple[Parsed, ...]) -> Parsed:
    """The conjunction of all operands."""
    parts: list[Formula | TimeBound] = []
    bound = None
    for operand in operands:
        if isinstance(operand, TimedParts):
            bound = bound or operand.bound
            parts += operand.parts
        else:
            parts.append(without_bounds(operand))
    if bound is None:
        return conjoin(*(part for part in parts if isinstance(part, Formula)))
    return TimedParts(tuple(parts), bound)


def without_bounds(part: Parsed) -> Formula:
    """A part that may contain no bound. Raises FormulaError if it has one."""
    if isinstance(part, Formula):
        return part
    raise error_at(
        part.bound,
        "time bounds stand at F and G (... -> F) of a whole line only",
        "write F[<=60s] at(A), G (alarm -> F[<=90s] at(A)) or revisit(A) <= 120 s as a line",
    )


def whole(part: Parsed) -> Formula | TimedFormula:
    """What a whole text stands for."""
    return TimedFormula(part.parts) if isinstance(part, TimedParts) else without_bounds(part)


def misplaced(kind: str, bound: str, before: str) -> tuple[str, str]:
    """What is wrong with a bound that the grammar does not allow here, and what to write instead.

    Args:
        kind: the kind of its token, BOUND or LIMIT.
        bound: the bound.
        before: the text up to it.
    """
    if kind == "BOUND" and before.rstrip().endswith(("(", ",")):
        return "a list has no brackets of its own here", "write e.g. patrolling(A, B)"
    name = re.search(r"(\w+)\s*$", before)
    if name is not None and name[1] in ("F_", "G_", "U_"):
        return f"{name[1]}{bound} is another notation", _WRITE["BOUND"]
    if name is not None and name[1] not in {operator.value for operator in TEMPORAL}:
        if kind == "BOUND":
            return (
                f"{name[1]}{bound} is not a fact",
                "write the name that it has under events alone",
            )
        if not bound.endswith(("s", "min")):
            what = f"a formula is made of facts, {name[1]} {bound} is a number compared"
            hint = "make an event of it, e.g. low: {when: BATTERY_STATUS.battery_remaining < 30}"
            return what, hint
    if kind == "BOUND":
        return "a time bound stands after F only", _WRITE["BOUND"]
    return "a limit in time follows revisit(...) only", f"{_WRITE['LIMIT']}, or F[<=60s] at(A)"


def _state_formula(part: Parsed, bound: Token) -> Formula:
    """A formula whose truth depends on one position only."""
    formula = without_bounds(part)
    temporal = next((f for f in subformulas(formula) if f.operator in TEMPORAL), None)
    if temporal is not None:
        raise error_at(
            bound,
            f"a time bound is about facts, and {str(temporal)[:60]} has an operator over time",
            "write facts, !, & and | there; name what comes later in a line of its own",
        )
    return formula


def _limit_ms(token: Token, text: str) -> int:
    """The limit of a bound, from its text."""
    write = _WRITE[token.type]
    found = _LIMIT.fullmatch(text.strip())
    if found is None:
        raise error_at(token, f"{token} is not a bound in time", write)
    if found["sign"] != "<=":
        raise error_at(token, "a time bound is <= a time", write)
    unit = found["unit"]
    if unit not in UNITS_S:
        what = f"the time has the unit {unit}" if unit else "the time has no unit"
        raise error_at(token, f"{what}: s and min are known", write)
    seconds = float(found["number"]) * UNITS_S[unit]
    if not MIN_LIMIT_S <= seconds <= MAX_LIMIT_S:
        hint = f"a bound is {MIN_LIMIT_S:g} s to {MAX_LIMIT_S / 60:g} min; plans keep 2 s in hand"
        raise error_at(token, f"no plan can be held to {found['number']} {unit}", hint)
    return round(1000 * seconds)
