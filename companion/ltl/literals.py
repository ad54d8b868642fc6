"""Which propositions a formula demands to be true, and which it demands to be false.

In negation normal form each proposition occurs as a literal: plain or negated. If it occurs only
plain, a word that satisfies the formula still does so when the proposition becomes true at more
positions. If it occurs only negated, the same holds for fewer positions.
"""

from __future__ import annotations

from typing import NamedTuple

from companion.ltl.formula import Formula, Operator, negation_normal_form, next_, subformulas


class Literals(NamedTuple):
    """The propositions that occur plain, and those that occur negated."""

    positive: frozenset[str]
    negative: frozenset[str]


def literals(formula: Formula) -> Literals:
    """The literals of a formula in negation normal form.

    >>> from companion.ltl.parser import parse
    >>> positive, negative = literals(parse("G (alarm -> F (seen & !lost)) & !done"))
    >>> sorted(positive), sorted(negative)
    (['seen'], ['alarm', 'done', 'lost'])
    """
    positive, negative = set[str](), set[str]()
    for node in subformulas(next_(negation_normal_form(formula))):  # so that an atom is an operand
        found = negative if node.operator is Operator.NOT else positive
        found.update(each.atom for each in node.operands if each.operator is Operator.ATOM)
    return Literals(frozenset(positive), frozenset(negative))
