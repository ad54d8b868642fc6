"""Reads the facts and literals of preconditions, effects and lists of beliefs.

The parser of the formula language reads them, so facts are spelled alike everywhere. Of its
operators only & and ! may be used here, and -> in effects.
"""

from __future__ import annotations

from companion.errors import FormulaError
from companion.ltl.conjuncts import conjuncts
from companion.ltl.formula import Formula, Operator
from companion.ltl.parser import parse
from companion.mission.facts import Atom
from companion.mission.skills import ConditionalEffectTemplate, Literal


def parse_literals(text: str) -> tuple[Literal, ...]:
    """Reads a conjunction of facts and negated facts.

    >>> [str(literal.atom.predicate) for literal in parse_literals("at(to) & !at(from)")]
    ['at', 'at']

    Raises:
        FormulaError: it is no formula, or has operators other than & and !.
    """
    return tuple(_literal(part, text) for part in conjuncts(parse(text)))


def parse_effect(text: str) -> tuple[tuple[Literal, ...], tuple[ConditionalEffectTemplate, ...]]:
    """Reads an effect: facts joined by &, and (condition -> effect) in parentheses.

    >>> plain, conditional = parse_effect("free & !has(x) & (lit & !late -> delivered(x))")
    >>> len(plain), [len(c.condition) for c in conditional]
    (2, [2])

    Raises:
        FormulaError: it is no formula, or has operators other than &, ! and ->.
    """
    plain: list[Literal] = []
    conditional: list[ConditionalEffectTemplate] = []
    for part in conjuncts(parse(text)):
        if part.operator is Operator.IMPLIES:
            condition, effect = (
                tuple(_literal(fact, text) for fact in conjuncts(side)) for side in part.operands
            )
            conditional.append(ConditionalEffectTemplate(condition, effect))
        else:
            plain.append(_literal(part, text))
    return tuple(plain), tuple(conditional)


def parse_fact(text: str) -> Atom:
    """Reads one fact, e.g. at(Home).

    Raises:
        FormulaError: it is anything else, such as half a fact, which a YAML list splits at its
            comma.
    """
    if is_begun(text):
        raise FormulaError(
            f"{text} is half a fact",
            text,
            text.index("("),
            hint='inside [ ] put quotes around a fact with a comma: "trans_ok(A, B)"',
        )
    formula = parse(text)
    if formula.operator is not Operator.ATOM:
        hint = "a fact looks like at(A)"
        if formula.operator is Operator.NOT:
            hint = "leave it out: what is not listed does not hold"
        raise FormulaError("not a fact", text, 0, len(text), hint)
    return Atom.parse(formula.atom)


def is_begun(text: str) -> bool:
    """Whether a parenthesis of a text is not closed, as when a YAML list splits it at its comma.

    >>> is_begun("trans_ok(A"), is_begun("B)"), is_begun("at(A)")
    (True, False, False)
    """
    return text.count("(") > text.count(")")


def _literal(part: Formula, text: str) -> Literal:
    is_positive = part.operator is not Operator.NOT
    fact = part if is_positive else part.operands[0]
    if fact.operator is not Operator.ATOM:
        raise FormulaError(
            f"{str(part)[:60]} is neither a fact nor the negation of one",
            text,
            len(text) - len(text.lstrip()),
            len(text.strip()),
            "write facts joined by &, each with ! for not; X F G U R W stand in the task alone",
        )
    return Literal(Atom.parse(fact.atom), is_positive)
