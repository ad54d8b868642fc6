"""Simplification: finds an equivalent formula that makes a smaller automaton.

It works on negation normal form. The laws of U and R are in `laws/fixpoints.py`, those of | and &
in `laws/chains.py`. They are applied from the operands to the whole until none applies any more.
"""

from __future__ import annotations

from companion.ltl.budget import Budget
from companion.ltl.formula import Formula, Operator
from companion.ltl.laws.chains import chain
from companion.ltl.laws.fixpoints import fixpoint
from companion.ltl.laws.implication import Implication
from companion.ltl.laws.sides import both_sides

_STEPS, _STEPS_AN_OPERAND = 100, 25  # for one law: at least so many, and more for each operand


def simplified(formula: Formula, budget: Budget | None = None) -> Formula:
    """An equivalent formula in negation normal form, given one in negation normal form.

    Raises:
        TranslationLimit: the budget is spent; without one there is no limit.

    >>> from companion.ltl.formula import negation_normal_form
    >>> from companion.ltl.parser import parse
    >>> str(simplified(negation_normal_form(parse("F F a | a U (b & false) | F b"))))
    'true U (a | b)'
    """
    budget = budget or Budget.unlimited()
    implication = Implication(*both_sides(), budget)
    final: dict[Formula, Formula] = {}
    pending = [formula]
    while pending:
        node = pending[-1]
        missing = [operand for operand in node.operands if operand not in final]
        if node in final:
            pending.pop()
            continue
        if missing:
            pending += missing
            continue
        rebuilt = Formula(node.operator, tuple(final[f] for f in node.operands), node.atom)
        budget.spend(_STEPS + _STEPS_AN_OPERAND * len(node.operands))
        result = _rewritten(rebuilt, implication) if rebuilt is node else rebuilt
        if result is node:
            final[node] = node
            implication.learn(node)
        elif result in final:
            final[node] = final[result]
        else:
            pending.append(result)
    return final[formula]


def _rewritten(node: Formula, implication: Implication) -> Formula:
    """The formula that one law makes simpler, or the node itself; the operands are simplified."""
    until, release = implication.until, implication.release
    match node.operator:
        case Operator.UNTIL:
            return fixpoint(node, until, release, implication)
        case Operator.RELEASE:
            return fixpoint(node, release, until, implication)
        case Operator.OR:
            return chain(node, until, release, implication)
        case Operator.AND:
            return chain(node, release, until, implication)
        case Operator.NEXT if node.operands[0] in until.pure and node.operands[0] in release.pure:
            return node.operands[0]  # X G F a = G F a
    return node
