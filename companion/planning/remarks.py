"""Hints for lines that are often written in a way that never holds.

Only the form of a formula is looked at, and the facts that hold now.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator

from companion.ltl.formula import Formula, Operator, subformulas
from companion.mission.facts import AT, Fact
from companion.planning.lasso import Conjunct


def remarks_on(conjuncts: Iterable[Conjunct], facts: Collection[Fact]) -> tuple[str, ...]:
    """The hints for lines that cannot hold.

    Args:
        conjuncts: the lines.
        facts: facts that hold now.
    """
    found = (remark for each in conjuncts for remark in _remarks(each.formula, facts))
    return tuple(dict.fromkeys(found))


def _remarks(formula: Formula, facts: Collection[Fact]) -> Iterator[str]:
    for node in subformulas(formula):
        places = [str(each) for each in node.operands if _is_place(each)]
        if node.operator is Operator.AND and len(places) > 1:
            one_by_one = " & ".join(f"F {place}" for place in places)
            yield f"the vehicle is at one place at a time: {one_by_one} goes to each"
    first = formula.operands[0] if formula.operands else formula
    if first.operator is not Operator.ATOM or Fact.parse(first.atom) in facts:
        return
    if formula.operator is Operator.ALWAYS:
        yield f"{first} is false now: F G {first} asks for it from some time on"
    if formula.operator in (Operator.UNTIL, Operator.WEAK_UNTIL):
        second = formula.operands[1]
        yield f"{first} is false now, and {formula} asks for it from now on until {second}"


def _is_place(formula: Formula) -> bool:
    return formula.operator is Operator.ATOM and Fact.parse(formula.atom).predicate == AT
