"""Splits a task into conjuncts, each of which has an automaton of its own."""

from __future__ import annotations

from companion.ltl.formula import (
    TEMPORAL,
    Formula,
    Operator,
    always,
    negate,
    negation_normal_form,
    subformulas,
)


def conjuncts(formula: Formula) -> tuple[Formula, ...]:
    """The formulas whose conjunction is the given one, split at & and at G over &.

    (f & g) | h is split as well if f or g is temporal and a finite prefix can show h, as it can
    show F c. So is !h -> f & g.

    >>> from companion.ltl.parser import parse
    >>> [str(f) for f in conjuncts(parse("G(a & F b & G(c & a)) & d"))]
    ['G a', 'G F b', 'G c', 'd']
    >>> [str(f) for f in conjuncts(parse("G F a & G F b | F c"))]
    ['G F a | F c', 'G F b | F c']
    """
    found: dict[Formula, None] = {}
    pending = [(formula, False)]
    while pending:
        part, is_always = pending.pop()
        if part.operator is Operator.AND:
            pending += [(operand, is_always) for operand in reversed(part.operands)]
        elif part.operator is Operator.ALWAYS:
            pending.append((part.operands[0], True))  # G G a is G a
        elif not is_always and (shared := _distributed(part)):
            pending += [(each, False) for each in reversed(shared)]
        else:
            found[always(part) if is_always else part] = None
    return tuple(found)


def _distributed(formula: Formula) -> list[Formula]:
    """The conjuncts of (f & g) | h, or of !h -> f & g; none if it cannot be split."""
    operator, operands = formula.operator, formula.operands
    if operator is Operator.IMPLIES:
        premise, conclusion = operands
        choices = [negate(premise), conclusion]
    elif operator is Operator.OR:
        choices = list(operands)
    else:
        return []
    for place, whole in enumerate(choices):
        before, after = operands[:place], operands[place + 1 :]
        others = [*choices[:place], *choices[place + 1 :]]
        if _is_temporal_conjunction(whole) and all(map(_is_guarantee, others)):
            return [Formula(operator, (*before, each, *after)) for each in whole.operands]
    return []


def _is_temporal_conjunction(formula: Formula) -> bool:
    """Whether a formula is a conjunction with an operand about other positions."""
    is_temporal = any(node.operator in TEMPORAL for node in subformulas(formula))
    return formula.operator is Operator.AND and is_temporal


def _is_guarantee(formula: Formula) -> bool:
    """Whether, by its operators, each word that satisfies a formula has a prefix that shows it."""
    nodes = subformulas(negation_normal_form(formula))
    return not any(node.operator is Operator.RELEASE for node in nodes)
