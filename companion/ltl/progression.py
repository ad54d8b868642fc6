"""Progression: what the rest of the word has to satisfy after a letter has been read.

A word satisfies a formula exactly if the word without its first letter satisfies the progressed
formula. It shows the obligations of a flight: after `a`, `G(a -> F b)` becomes itself and `F b`.

Source: Bacchus and Kabanza, Planning for temporally extended goals, Annals of Mathematics and
Artificial Intelligence 22, 1998, Section 3.
"""

from __future__ import annotations

from companion.ltl.formula import (
    FALSE,
    TRUE,
    Formula,
    Operator,
    conjoin,
    disjoin,
    negate,
    subformulas,
)


def progressed(formula: Formula, letter: frozenset[str]) -> Formula:
    """What the rest of a word has to satisfy.

    Args:
        formula: what the whole word has to satisfy.
        letter: the propositions that hold at its first position.

    >>> from companion.ltl.parser import parse
    >>> [str(progressed(parse("G(a -> F b)"), frozenset(letter))) for letter in ("a", "ab")]
    ['F b & G(a -> F b)', 'G(a -> F b)']
    >>> [str(progressed(parse("a U b"), frozenset(letter))) for letter in ("", "a", "b")]
    ['false', 'a U b', 'true']
    """
    after: dict[Formula, Formula] = {}
    for node in subformulas(formula):
        after[node] = _progressed(node, [after[each] for each in node.operands], letter)
    return after[formula]


def _progressed(node: Formula, after: list[Formula], letter: frozenset[str]) -> Formula:
    match node.operator:
        case Operator.ATOM:
            return TRUE if node.atom in letter else FALSE
        case Operator.NOT:
            return _not(after[0])
        case Operator.NEXT:
            return node.operands[0]
        case Operator.AND:
            return _all(*after)
        case Operator.OR:
            return _any(*after)
        case Operator.IMPLIES:
            return _any(_not(after[0]), after[1])
        case Operator.IFF:
            return _any(_all(*after), _all(*map(_not, after)))
        case Operator.EVENTUALLY:
            return _any(after[0], node)
        case Operator.ALWAYS:
            return _all(after[0], node)
        case Operator.UNTIL | Operator.WEAK_UNTIL:
            return _any(after[1], _all(after[0], node))
        case Operator.RELEASE:
            return _all(after[1], _any(after[0], node))
        case _:
            return node


def _not(formula: Formula) -> Formula:
    return {TRUE: FALSE, FALSE: TRUE}.get(formula) or negate(formula)


def _all(*formulas: Formula) -> Formula:
    """The conjunction of some formulas, each part once."""
    parts = _flat(formulas, Operator.AND)
    return FALSE if FALSE in parts else conjoin(*(each for each in parts if each is not TRUE))


def _any(*formulas: Formula) -> Formula:
    """The disjunction of some formulas, each part once."""
    parts = _flat(formulas, Operator.OR)
    parts = tuple(each for each in parts if not _is_implied(each, parts))
    return TRUE if TRUE in parts else disjoin(*(each for each in parts if each is not FALSE))


def _is_implied(formula: Formula, parts: tuple[Formula, ...]) -> bool:
    """Whether a part of a disjunction is redundant: a beside F a, F(a & F b) beside F b.

    >>> from companion.ltl.parser import parse
    >>> str(_any(parse("G a"), parse("F G a")))
    'F G a'
    """
    if any(e.operator is Operator.EVENTUALLY and e.operands[0] is formula for e in parts):
        return True
    inner = formula.operands[0] if formula.operator is Operator.EVENTUALLY else formula
    return inner.operator is Operator.AND and any(
        each.operator is Operator.EVENTUALLY and each in parts for each in inner.operands
    )


def _flat(formulas: tuple[Formula, ...], operator: Operator) -> tuple[Formula, ...]:
    """Flattens nested operands of one operator; each once, in their order."""
    nested = (each.operands if each.operator is operator else (each,) for each in formulas)
    return tuple(dict.fromkeys(part for parts in nested for part in parts))
