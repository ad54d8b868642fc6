"""The two sides of the laws: U with |, and R with &.

In negation normal form every law has a dual: exchange & with |, U with R, true with false. So each
law is written once, for a `Side` that stands for U or for R; comments show the case of U. A formula
is *eventual* if it holds whenever it holds at a later position (F a). It is *universal* if, once it
holds, it also holds at every later position (G a). A formula that is both (G F a) is *ageless*: it
does not depend on any finite prefix.

Source: Etessami and Holzmann, Optimizing Büchi automata, CONCUR 2000; Somenzi and Bloem,
Efficient Büchi automata from LTL formulae, CAV 2000.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from companion.ltl.formula import FALSE, TRUE, Formula, Operator, subformulas

_NEUTRAL = {Operator.AND: TRUE, Operator.OR: FALSE}


@dataclass(frozen=True, slots=True, eq=False)
class Side:
    """U with its laws, where F is `true U`; or its dual R, where G is `false R`.

    Attributes:
        fixpoint: U.
        join: |, over which the right operand of U distributes.
        meet: &, over which the left operand of U distributes.
        top: true, the left operand that makes U an F.
        bottom: false.
        pure: the eventual formulas, for which F f = f; grows with the formulas seen.
    """

    fixpoint: Operator
    join: Operator
    meet: Operator
    top: Formula
    bottom: Formula
    pure: set[Formula] = field(default_factory=set)

    def make(self, left: Formula, right: Formula) -> Formula:
        """`left U right`."""
        return Formula(self.fixpoint, (left, right))

    def far(self, formula: Formula) -> Formula:
        """`F formula`."""
        return self.make(self.top, formula)

    def is_far(self, formula: Formula) -> bool:
        """Whether a formula is an F."""
        return formula.operator is self.fixpoint and formula.operands[0] is self.top

    def classify(self, node: Formula) -> None:
        """Adds a node to the pure formulas if it is one; its operands have been classified."""
        operands = node.operands
        match node.operator:
            case Operator.ATOM | Operator.NOT:
                return
            case Operator.UNTIL | Operator.RELEASE:
                is_pure = operands[1] in self.pure or self.is_far(node)
            case _:
                is_pure = all(operand in self.pure for operand in operands)
        if is_pure:
            self.pure.add(node)


def both_sides() -> tuple[Side, Side]:
    """The sides of U and of R, for one formula."""
    return (
        Side(Operator.UNTIL, Operator.OR, Operator.AND, TRUE, FALSE),
        Side(Operator.RELEASE, Operator.AND, Operator.OR, FALSE, TRUE),
    )


def is_ageless(formula: Formula) -> bool:
    """Whether the shape of a formula in negation normal form shows that it depends on no prefix.

    >>> from companion.ltl.formula import negation_normal_form
    >>> from companion.ltl.parser import parse
    >>> [is_ageless(negation_normal_form(parse(text))) for text in ("G F a & F G b", "F a")]
    [True, False]
    """
    sides = both_sides()
    for node in subformulas(formula):
        for side in sides:
            side.classify(node)
    return all(formula in side.pure for side in sides)


def is_waiting(formula: Formula, side: Side) -> bool:
    """Whether a formula is an F on the side of U; the treatment of these has no useful dual."""
    return side.fixpoint is Operator.UNTIL and side.is_far(formula)


def joined(operator: Operator, parts: list[Formula]) -> Formula:
    """A chain of | or &; the formula itself for one, the neutral element for none.

    >>> joined(Operator.AND, []) is TRUE
    True
    """
    if len(parts) > 1:
        return Formula(operator, tuple(parts))
    return parts[0] if parts else _NEUTRAL[operator]
