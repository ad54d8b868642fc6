"""Formulas of linear temporal logic: syntax tree, printing, normal form.

    true false  at(A)  ! X F G (tightest)  U R W  &  |  ->  <-> (weakest)

U, R, W, -> and <-> associate to the right. `F a` is `true U a`, `G a` is `false R a`, and `a W b`
is `b R (a | b)`. Formulas are interned: structurally equal ones are one object, so they are
compared and hashed by identity. No function here is recursive, so only memory limits the depth of a
formula. `parser.py` reads text, `semantics.py` defines the meaning, `translate.py` makes the
automaton.

Source: the paper, Section II-C; Baier and Katoen, Principles of Model Checking, Chapter 5.

>>> from companion.ltl.parser import atom, parse
>>> str(parse("G ((targetFound || targetReported) -> F(targetReported))"))
'G(targetFound | targetReported -> F targetReported)'
>>> parse("a & b") is conjoin(atom("a"), atom("b"))
True
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import Enum
from weakref import WeakValueDictionary


class Operator(Enum):
    """The kind of a node of the syntax tree; the value is how it is written."""

    TRUE = "true"
    FALSE = "false"
    ATOM = "atom"
    NOT = "!"
    NEXT = "X"
    EVENTUALLY = "F"
    ALWAYS = "G"
    UNTIL = "U"
    RELEASE = "R"
    WEAK_UNTIL = "W"
    AND = "&"
    OR = "|"
    IMPLIES = "->"
    IFF = "<->"


TEMPORAL = frozenset(
    {
        Operator.NEXT,
        Operator.EVENTUALLY,
        Operator.ALWAYS,
        Operator.UNTIL,
        Operator.RELEASE,
        Operator.WEAK_UNTIL,
    }
)
"""The operators that are about other positions too."""

_Key = tuple[Operator, tuple["Formula", ...], str]
_interned: WeakValueDictionary[_Key, Formula] = WeakValueDictionary()


@dataclass(frozen=True, eq=False, init=False, repr=False, slots=True, weakref_slot=True)
class Formula:
    """A node of the syntax tree; structurally equal formulas are one object.

    Attributes:
        operands: none for true, false and atoms; two or more for & and |; else one or two.
        atom: canonical text of an atom, e.g. `trans_ok(A, B)`; "" for every other node.
    """

    operator: Operator
    operands: tuple[Formula, ...]
    atom: str

    def __new__(
        cls, operator: Operator, operands: tuple[Formula, ...] = (), atom: str = ""
    ) -> Formula:
        """The only object with these fields."""
        key = (operator, operands, atom)
        formula = _interned.get(key)
        if formula is None:
            formula = object.__new__(cls)
            object.__setattr__(formula, "operator", operator)
            object.__setattr__(formula, "operands", operands)
            object.__setattr__(formula, "atom", atom)
            _interned[key] = formula
        return formula

    def __str__(self) -> str:
        """The formula with as few parentheses as possible; `parse` can read it."""
        return _written(self, 0)

    def __repr__(self) -> str:
        return f"parse({str(self)!r})"

    def __reduce__(self) -> tuple[type[Formula], _Key]:
        """Pickles the fields, so that the other process interns its copy."""
        return (Formula, (self.operator, self.operands, self.atom))


TRUE = Formula(Operator.TRUE)
FALSE = Formula(Operator.FALSE)

_STRENGTH = {
    Operator.IFF: 1,
    Operator.IMPLIES: 2,
    Operator.OR: 3,
    Operator.AND: 4,
    Operator.UNTIL: 5,
    Operator.RELEASE: 5,
    Operator.WEAK_UNTIL: 5,
    Operator.NOT: 6,
    Operator.NEXT: 6,
    Operator.EVENTUALLY: 6,
    Operator.ALWAYS: 6,
    Operator.ATOM: 7,
    Operator.TRUE: 7,
    Operator.FALSE: 7,
}
"""Binding strength; an operand that binds less than its place requires gets parentheses."""


def operand_text(formula: Formula, operator: Operator) -> str:
    """A formula as it is written when it is the first operand of an operator.

    >>> from companion.ltl.parser import parse
    >>> operand_text(parse("a | b"), Operator.EVENTUALLY)
    '(a | b)'
    """
    strength = _STRENGTH[operator]
    return _written(formula, strength if operator in _PREFIXES else strength + 1)


_PREFIXES = (Operator.NOT, Operator.NEXT, Operator.EVENTUALLY, Operator.ALWAYS)


def _written(whole: Formula, least: int) -> str:
    """The text of a formula, in parentheses if it binds less than `least`."""
    written: list[str] = []
    pending: list[str | tuple[Formula, int]] = [(whole, least)]
    while pending:
        item = pending.pop()
        if isinstance(item, str):
            written.append(item)
            continue
        formula, strength = item
        pieces = _pieces(formula)
        if _STRENGTH[formula.operator] < strength:
            pieces = ["(", *pieces, ")"]
        pending += reversed(pieces)
    return "".join(written)


def _pieces(formula: Formula) -> list[str | tuple[Formula, int]]:
    """Text and operands of one node, each operand with the strength that its place requires."""
    operator, operands = formula.operator, formula.operands
    strength = _STRENGTH[operator]
    if not operands:
        return [formula.atom or operator.value]
    if len(operands) == 1:
        needs_space = operator is not Operator.NOT and _STRENGTH[operands[0].operator] >= strength
        return [operator.value + (" " if needs_space else ""), (operands[0], strength)]
    pieces: list[str | tuple[Formula, int]] = [(operands[0], strength + 1)]
    for operand in operands[1:]:
        pieces += [f" {operator.value} ", (operand, strength + 1)]
    if operator not in (Operator.AND, Operator.OR):
        pieces[-1] = (operands[1], strength)  # these operators are right associative
    return pieces


def negate(formula: Formula) -> Formula:
    """The negation of a formula; the negation of a negation is its operand.

    >>> from companion.ltl.parser import parse
    >>> str(negate(parse("F a"))), str(negate(parse("!a")))
    ('!F a', 'a')
    """
    if formula.operator is Operator.NOT:
        return formula.operands[0]
    return Formula(Operator.NOT, (formula,))


def conjoin(*formulas: Formula) -> Formula:
    """The conjunction; true for no formula, the formula itself for one.

    >>> str(conjoin()), str(conjoin(TRUE, FALSE))
    ('true', 'true & false')
    """
    return Formula(Operator.AND, formulas) if len(formulas) > 1 else (*formulas, TRUE)[0]


def disjoin(*formulas: Formula) -> Formula:
    """The disjunction; false for no formula, the formula itself for one."""
    return Formula(Operator.OR, formulas) if len(formulas) > 1 else (*formulas, FALSE)[0]


def implies(condition: Formula, consequence: Formula) -> Formula:
    """`condition -> consequence`."""
    return Formula(Operator.IMPLIES, (condition, consequence))


def next_(formula: Formula) -> Formula:
    """`X formula`: at the next position."""
    return Formula(Operator.NEXT, (formula,))


def eventually(formula: Formula) -> Formula:
    """`F formula`: now or later."""
    return Formula(Operator.EVENTUALLY, (formula,))


def always(formula: Formula) -> Formula:
    """`G formula`: now and for ever."""
    return Formula(Operator.ALWAYS, (formula,))


def until(before: Formula, event: Formula) -> Formula:
    """`before U event`: the event comes, and `before` holds until then."""
    return Formula(Operator.UNTIL, (before, event))


def release(event: Formula, kept: Formula) -> Formula:
    """`event R kept`: `kept` holds up to and including the event, or for ever."""
    return Formula(Operator.RELEASE, (event, kept))


def weak_until(before: Formula, event: Formula) -> Formula:
    """`before W event`: like U, but the event need not come."""
    return Formula(Operator.WEAK_UNTIL, (before, event))


def subformulas(formula: Formula) -> Iterator[Formula]:
    """Every distinct node once, operands before the nodes that contain them.

    >>> from companion.ltl.parser import parse
    >>> [str(f) for f in subformulas(parse("F(a & b) | a"))]
    ['a', 'b', 'a & b', 'F(a & b)', 'F(a & b) | a']
    """
    seen: set[Formula] = set()
    pending = [(formula, False)]
    while pending:
        node, is_ready = pending.pop()
        if is_ready:
            yield node
        elif node not in seen:
            seen.add(node)
            pending.append((node, True))
            pending += [(operand, False) for operand in reversed(node.operands)]


def atoms(formula: Formula) -> frozenset[str]:
    """The propositions that a formula mentions.

    >>> from companion.ltl.parser import parse
    >>> sorted(atoms(parse("G(at( A ) -> X trans_ok(A,B))")))
    ['at(A)', 'trans_ok(A, B)']
    """
    return frozenset(f.atom for f in subformulas(formula) if f.operator is Operator.ATOM)


def dual(node: Formula, negated: Iterable[Formula]) -> Formula:
    """The negation of a node in negation normal form, given the negations of its operands."""
    if node.operator in (Operator.ATOM, Operator.NOT):
        return negate(node)
    return Formula(_DUAL[node.operator], tuple(negated))


_DUAL = {
    Operator.TRUE: Operator.FALSE,
    Operator.FALSE: Operator.TRUE,
    Operator.AND: Operator.OR,
    Operator.OR: Operator.AND,
    Operator.NEXT: Operator.NEXT,
    Operator.UNTIL: Operator.RELEASE,
    Operator.RELEASE: Operator.UNTIL,
}
"""The operator that remains when a negation moves on to the operands."""


def negation_normal_form(formula: Formula) -> Formula:
    """An equivalent formula of literals, true, false, &, |, X, U and R only.

    >>> from companion.ltl.parser import parse
    >>> str(negation_normal_form(parse("!(G a -> b W c)")))
    'false R a & !c U (!b & !c)'
    """
    core: dict[Formula, Formula] = {}
    negated: dict[Formula, Formula] = {}
    for node in subformulas(formula):
        core[node], negated[node] = _both_polarities(
            node.operator,
            node,
            [core[f] for f in node.operands],
            [negated[f] for f in node.operands],
        )
    return core[formula]


def _both_polarities(
    operator: Operator, node: Formula, plain: list[Formula], negated: list[Formula]
) -> tuple[Formula, Formula]:
    """Normal forms of a node and of its negation, given both forms of its operands."""
    match operator:
        case Operator.ATOM:
            return node, Formula(Operator.NOT, (node,))
        case Operator.NOT:
            return negated[0], plain[0]
        case Operator.IMPLIES:
            return disjoin(negated[0], plain[1]), conjoin(plain[0], negated[1])
        case Operator.IFF:
            a, b, not_a, not_b = *plain, *negated
            return (
                disjoin(conjoin(a, b), conjoin(not_a, not_b)),
                disjoin(conjoin(a, not_b), conjoin(not_a, b)),
            )
        case Operator.EVENTUALLY:
            return until(TRUE, plain[0]), release(FALSE, negated[0])
        case Operator.ALWAYS:
            return release(FALSE, plain[0]), until(TRUE, negated[0])
        case Operator.WEAK_UNTIL:
            a, b, not_a, not_b = *plain, *negated
            return release(b, disjoin(a, b)), until(not_b, conjoin(not_a, not_b))
        case _:
            return (
                Formula(operator, tuple(plain)),
                Formula(_DUAL[operator], tuple(negated)),
            )
