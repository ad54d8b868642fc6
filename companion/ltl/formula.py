"""What does a task say? Formulas of linear temporal logic: syntax tree, reading, printing.

    true false  at(A)  ! X F G (tightest)  U R W  &  |  ->  <-> (weakest)

U, R, W, -> and <-> associate to the right. `F a` is `true U a`, `G a` is `false R a`, and
`a W b` is `b R (a | b)`. Formulas are interned: the same text gives the same object, so they
are compared and hashed by identity. Nothing here recurses: a formula may be as deep as memory
allows. The meaning of a formula is in `semantics.py`, its automaton in `translate.py`.

Source: the paper, Section II-C; Baier and Katoen, Principles of Model Checking, Chapter 5.

>>> str(parse("G ((targetFound || targetReported) -> F(targetReported))"))
'G(targetFound | targetReported -> F targetReported)'
>>> parse("a & b") is conjoin(atom("a"), atom("b"))
True
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cache
from weakref import WeakValueDictionary

from lark import Lark, Token, Transformer, v_args
from lark.exceptions import UnexpectedCharacters, UnexpectedToken

from companion.errors import FormulaError


class Operator(Enum):
    """What a node of the syntax tree is; the value is how it is written."""

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
        """The one object for these fields."""
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
        """The formula with as few parentheses as possible; `parse` reads it back."""
        written: list[str] = []
        pending: list[str | tuple[Formula, int]] = [(self, 0)]
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

    def __repr__(self) -> str:
        return f"parse({str(self)!r})"

    def __reduce__(self) -> tuple[Callable[[str], Formula], tuple[str]]:
        """Pickled as text, so that a copy in another process is interned there."""
        return (parse, (str(self),))


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
"""Binding strength; an operand weaker than its place needs parentheses."""


def _pieces(formula: Formula) -> list[str | tuple[Formula, int]]:
    """Text and operands of one node, each operand with the strength that its place asks for."""
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
        pieces[-1] = (operands[1], strength)  # right associative
    return pieces


def atom(text: str) -> Formula:
    """The proposition of a text, e.g. `at(A)`. Raises FormulaError if it is anything else."""
    formula = parse(text)
    if formula.operator is not Operator.ATOM:
        raise FormulaError(
            "not a proposition", text, 0, len(text), "a proposition looks like at(A)"
        )
    return formula


def negate(formula: Formula) -> Formula:
    """The negation; of a negation, its operand."""
    if formula.operator is Operator.NOT:
        return formula.operands[0]
    return Formula(Operator.NOT, (formula,))


def conjoin(*formulas: Formula) -> Formula:
    """All of the formulas; true for none, the formula itself for one."""
    return Formula(Operator.AND, formulas) if len(formulas) > 1 else (*formulas, TRUE)[0]


def disjoin(*formulas: Formula) -> Formula:
    """At least one of the formulas; false for none, the formula itself for one."""
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
    """`before U event`: the event comes, and up to then `before` holds."""
    return Formula(Operator.UNTIL, (before, event))


def release(event: Formula, kept: Formula) -> Formula:
    """`event R kept`: `kept` holds up to and including the event, or for ever."""
    return Formula(Operator.RELEASE, (event, kept))


def weak_until(before: Formula, event: Formula) -> Formula:
    """`before W event`: as U, but the event need not come."""
    return Formula(Operator.WEAK_UNTIL, (before, event))


def subformulas(formula: Formula) -> Iterator[Formula]:
    """Every distinct node once, operands before the nodes that they are part of.

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

    >>> sorted(atoms(parse("G(at( A ) -> X trans_ok(A,B))")))
    ['at(A)', 'trans_ok(A, B)']
    """
    return frozenset(f.atom for f in subformulas(formula) if f.operator is Operator.ATOM)


def conjuncts(formula: Formula) -> tuple[Formula, ...]:
    """The formulas whose conjunction is the given one, split at & and at G over &.

    >>> [str(f) for f in conjuncts(parse("G(a & F b & G(c & a)) & d"))]
    ['G a', 'G F b', 'G c', 'd']
    """
    found: dict[Formula, None] = {}
    pending = [(formula, False)]
    while pending:
        part, is_always = pending.pop()
        if part.operator is Operator.AND:
            pending += [(operand, is_always) for operand in reversed(part.operands)]
        elif part.operator is Operator.ALWAYS:
            pending.append((part.operands[0], True))  # G G a is G a
        else:
            found[always(part) if is_always else part] = None
    return tuple(found)


_DUAL = {
    Operator.TRUE: Operator.FALSE,
    Operator.FALSE: Operator.TRUE,
    Operator.AND: Operator.OR,
    Operator.OR: Operator.AND,
    Operator.NEXT: Operator.NEXT,
    Operator.UNTIL: Operator.RELEASE,
    Operator.RELEASE: Operator.UNTIL,
}
"""What a negation makes of an operator when it moves on to the operands."""


def negation_normal_form(formula: Formula) -> Formula:
    """An equivalent formula of literals, true, false, &, |, X, U and R only.

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


@v_args(inline=True)
class _Builder(Transformer[Token, Formula]):
    """Makes formulas while the text is parsed, one method a rule of grammar.lark."""

    def constant(self, name: Token) -> Formula:
        return Formula(Operator(name))

    def proposition(self, name: Token, *arguments: Token) -> Formula:
        return Formula(Operator.ATOM, (), _canonical(name, arguments))

    def unary(self, operator: Token, operand: Formula) -> Formula:
        return Formula(Operator(operator), (operand,))

    def binary(self, left: Formula, operator: Token, right: Formula) -> Formula:
        return Formula(Operator(operator), (left, right))

    def conjunction(self, *operands: Formula) -> Formula:
        return conjoin(*operands)

    def disjunction(self, *operands: Formula) -> Formula:
        return disjoin(*operands)


def _canonical(name: str, arguments: Sequence[str]) -> str:
    return f"{name}({', '.join(arguments)})" if arguments else str(name)


@cache
def _parser() -> Lark:
    # The basic lexer keeps `U` an operator even where only a proposition could stand.
    return Lark.open(
        "grammar.lark", rel_to=__file__, parser="lalr", lexer="basic", transformer=_Builder()
    )


def parse(text: str) -> Formula:
    """The formula of a text. Raises FormulaError with the offending token underlined.

    >>> parse("G F at(A) U")
    Traceback (most recent call last):
    companion.errors.FormulaError: the formula ends too early
        G F at(A) U
                   ^  expected a proposition such as at(A), true, false, ( or one of ! X F G
    """
    try:
        formula: Formula = _parser().parse(text)  # type: ignore[assignment]
    except UnexpectedCharacters as error:
        offset = error.pos_in_stream or 0
        raise FormulaError(
            f"{text[offset]!r} has no meaning in a formula", text, offset, 1, _NOTATION
        ) from None
    except UnexpectedToken as error:
        raise _explained(error, text) from None
    return formula


def occurrences(text: str) -> list[tuple[str, int, int]]:
    """Where a formula's text mentions propositions. Raises FormulaError as `parse` does.

    Returns:
        (canonical text, offset, length) of every mention, in the order of the text.

    >>> occurrences("F at( A ) | done")
    [('at(A)', 2, 7), ('done', 12, 4)]
    """
    parse(text)
    found = []
    tokens = [*_parser().lex(text), Token("$END", "")]
    position = 0
    while tokens[position].type != "$END":
        first = last = tokens[position]
        position += 1
        if first.type != "NAME":
            continue
        arguments = []
        if tokens[position].type == "_OPEN":
            while last.type != "_CLOSE":
                last = tokens[position]
                arguments.append(last)
                position += 1
        assert first.start_pos is not None and last.end_pos is not None
        canonical = _canonical(first, arguments[1::2])  # between brackets and commas
        found.append((canonical, first.start_pos, last.end_pos - first.start_pos))
    return found


_NOTATION = "a formula is made of names such as at(A), true, false, ( ) ! & | -> <-> X F G U R W"

_EXPECTED = (
    ("NOT", "a proposition such as at(A), true, false, ( or one of ! X F G"),
    ("NAME", "the name of an argument"),
    ("_COMMA", "a comma or )"),
    ("_CLOSE", "an operator (& | -> <-> U R W) or )"),
    ("$END", "an operator (& | -> <-> U R W) or the end"),
)
"""The first terminal that the parser would accept tells what it was waiting for."""


def _explained(error: UnexpectedToken, text: str) -> FormulaError:
    accepted = error.accepts or set()
    hint = next((f"expected {words}" for terminal, words in _EXPECTED if terminal in accepted), "")
    if error.token.type == "$END":
        return FormulaError("the formula ends too early", text, len(text.rstrip()), 1, hint)
    offset = error.token.start_pos or 0
    glued = re.search(r"\b[XFG]{2,}\s*$", text[:offset])
    if glued:
        operators = glued.group().strip()
        what = f"{operators!r} is read as a proposition"
        advice = f"did you mean {' '.join(operators)!r}?"
        return FormulaError(what, text, glued.start(), len(operators), advice)
    return FormulaError(f"unexpected {str(error.token)!r}", text, offset, len(error.token), hint)
