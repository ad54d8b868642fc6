"""Parsing: reads formulas from text, and explains what cannot be read.

The grammar is in `grammar.lark`. A mission pattern, e.g. `patrolling(A, B)`, is read as the formula
that it stands for (`patterns.py`); `bound_parsing.py` handles time bounds. No function here is
recursive: the parser is LALR and builds the tree bottom-up. A text that exceeds the limits below is
refused before it is read.

>>> parse("visit(A, B)") is parse("F at(A) & F at(B)")
True
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from lark import Token, Transformer, v_args

from companion.errors import FormulaError
from companion.grammars import END, Grammar, Misfit, error_at, span
from companion.ltl import bound_parsing
from companion.ltl.bound_parsing import Parsed, TimedAnswer, without_bounds
from companion.ltl.formula import Formula, Operator, disjoin
from companion.ltl.patterns import AT, PATTERNS
from companion.ltl.timed_formula import Line, TimedFormula, untimed


@v_args(inline=True)
class _FormulaBuilder(Transformer[Token, Line]):
    """Makes formulas during parsing, with one method for each rule of grammar.lark."""

    def start(self, part: Parsed) -> Line:
        return bound_parsing.whole(part)

    def constant(self, name: Token) -> Formula:
        return Formula(Operator(name))

    def proposition(self, name: Token, *arguments: Token) -> Parsed:
        if arguments and name in PATTERNS:
            pattern = PATTERNS[name]
            misfit = pattern.misfit(arguments)
            if misfit is not None:
                index, what = misfit
                token = name if index is None else arguments[index]
                raise error_at(token, what, f"write {pattern.signature}")
            return parse(pattern.expansion(arguments))
        for argument in arguments:
            if argument.type in (_FACT, "NUMBER"):
                what = f"an argument of {name} cannot be {argument}"
                raise error_at(argument, what, "expected the name of an argument")
        return Formula(Operator.ATOM, (), _canonical(name, arguments))

    def fact(self, name: Token, *rest: Token) -> Token:
        return _fact(name, rest[1::2], rest[-1])  # the arguments, without brackets and commas

    def unary(self, operator: Token, operand: Parsed) -> Parsed:
        if isinstance(operand, TimedAnswer) and operator == Operator.ALWAYS.value:
            return bound_parsing.response(operand)
        return Formula(Operator(operator), (without_bounds(operand),))

    def within(self, operator: Token, bound: Token, goal: Parsed) -> Parsed:
        return bound_parsing.within(bound, goal)

    def revisit(self, name: Token, goal: Token | Parsed, limit: Token | None = None) -> Parsed:
        if isinstance(goal, Token):  # a place, as in a pattern
            goal = Formula(Operator.ATOM, (), _canonical(AT, [goal]))
        return bound_parsing.revisit(name, goal, limit)

    def binary(self, left: Parsed, operator: Token, right: Parsed) -> Parsed:
        if operator == Operator.IMPLIES.value:
            return bound_parsing.implication(left, right)
        return Formula(Operator(operator), (without_bounds(left), without_bounds(right)))

    def conjunction(self, *operands: Parsed) -> Parsed:
        return bound_parsing.conjunction(operands)

    def disjunction(self, *operands: Parsed) -> Parsed:
        return disjoin(*map(without_bounds, operands))


def _canonical(name: str, arguments: Sequence[str]) -> str:
    return f"{name}({', '.join(arguments)})" if arguments else str(name)


_FACT = "FACT"
"""Type of a token that stands for a whole proposition as an argument of a pattern."""


def _fact(name: Token, arguments: Sequence[Token], closing: Token) -> Token:
    text = _canonical(name, arguments)
    return Token(_FACT, text, start_pos=name.start_pos, end_pos=closing.end_pos)


MAX_CHARACTERS = 250_000
MAX_ARGUMENTS = 10_000
"""These limits of a text save time and memory: each argument of a pattern is read several times."""

# With the basic lexer, `U` is always an operator, even where only a proposition is possible.
_FORMULAS = Grammar(
    "formula", "grammar.lark", __file__, _FormulaBuilder(), most=MAX_CHARACTERS, is_contextual=False
)


def parse(text: str) -> Formula:
    """Parses a formula. Raises FormulaError with the offending token underlined.

    >>> parse("G F at(A) U")
    Traceback (most recent call last):
    companion.errors.FormulaError: the formula ends too early
        G F at(A) U
                   ^  expected a proposition such as at(A), true, false, ( or one of ! X F G
    """
    line = parse_line(text)
    if isinstance(line, TimedFormula):
        advice = f"a mission has it in a line under task:, soon: {line}; here write {untimed(line)}"
        raise FormulaError("this cannot have a time bound", text, 0, len(text), advice)
    return line


def parse_line(text: str) -> Line:
    """Parses a line of a task, which may have time bounds. Raises FormulaError as `parse` does.

    >>> str(parse_line("G (alarm -> F[<=1.5 min] at(A))"))
    'G(alarm -> F[<=90s] at(A))'
    """
    _FORMULAS.refuse_more("arguments", text.count(","), MAX_ARGUMENTS, text)
    line = _FORMULAS.read(text)
    if isinstance(line, Misfit):
        raise _explained(line, text) if line.kind else _meaningless(text, line.offset)
    return line


def occurrences(text: str) -> list[tuple[str, int, int]]:
    """Finds the propositions that a text mentions. Raises FormulaError as `parse_line` does.

    Returns:
        (canonical text, offset, length) of every mention, in the order of the text. An argument
        of a mission pattern is a mention of the proposition that it stands for.

    >>> occurrences("F at( A ) | done")
    [('at(A)', 2, 7), ('done', 12, 4)]
    >>> occurrences("patrolling(A, B)")
    [('at(A)', 11, 1), ('at(B)', 14, 1)]
    """
    parse_line(text)
    found = []
    tokens = [*_FORMULAS.tokens(text), Token(END, "")]
    position = 0
    while tokens[position].type != END:
        name = tokens[position]
        if name.type == "REVISIT" and tokens[position + 3].type == "_CLOSE":
            place = tokens[position + 2]
            if place.type not in ("TRUE", "FALSE"):
                found.append((_canonical(AT, [place]), *span(place, place)))
            position += 3
        if name.type != "NAME":
            position += 1
            continue
        arguments, position = _arguments_after(tokens, position)
        if arguments and name in PATTERNS:
            for index, argument in enumerate(arguments):
                proposition = PATTERNS[name].proposition(index, argument)
                if proposition is not None:
                    found.append((proposition, *span(argument, argument)))
        else:
            found.append((_canonical(name, arguments), *span(name, tokens[position - 1])))
    return found


def _arguments_after(tokens: Sequence[Token], position: int) -> tuple[list[Token], int]:
    """The arguments of the name at a position, and the position after them."""
    arguments: list[Token] = []
    position += 1
    if tokens[position].type != "_OPEN":
        return arguments, position
    while tokens[position].type != "_CLOSE":  # at the bracket, then at a comma
        name = tokens[position + 1]
        inner, position = _arguments_after(tokens, position + 1)
        arguments.append(_fact(name, inner, tokens[position - 1]) if inner else name)
    return arguments, position + 1


_NOTATION = "a formula is made of names such as at(A), true, false, ( ) ! & | -> <-> X F G U R W"

_EXPECTED = (
    ("NOT", "a proposition such as at(A), true, false, ( or one of ! X F G"),
    ("NAME", "the name of an argument"),
    ("_COMMA", "a comma or )"),
    ("_CLOSE", "an operator (& | -> <-> U R W) or )"),
    (END, "an operator (& | -> <-> U R W) or the end"),
)
"""The first of these terminals that the parser would accept tells what was expected."""


_FOREIGN = {
    "=>": "->", "--": "->", "==>": "->", "→": "->", "⇒": "->", "implies": "->",
    "<=>": "<->", "↔": "<->", "==": "<->", "iff": "<->",
    "□": "G", "[]": "G", "always": "G", "globally": "G", "◇": "F", "<>": "F", "eventually": "F",
    "finally": "F", "○": "X", "next": "X", "until": "U", "release": "R", "and": "&", "∧": "&",
    "or": "|", "∨": "|", "not": "!", "¬": "!", "~": "!", "within": "F[<=60s] at(A)",
    "every": "revisit(A) <= 5 min", "AG": "G", "AF": "F", "AX": "X",
    **dict.fromkeys(("EF", "EG", "EX"), "F, G or X: a plan is one path"),
    **dict.fromkeys(("S", "since", "O", "once", "H", "Y"),
                    "what has to come: formulas look forwards, with X F G U R W"),
    "forall": "at(A) & at(B), or a pattern such as visit(A, B)", "exists": "at(A) | at(B)",
}  # fmt: skip
"""Spellings of other tools and books -> ours."""
_WORDS = re.compile(r"\w+|<=>|[^\w\s()]{1,2}")


def _in_another_notation(text: str, offset: int) -> FormulaError | None:
    """An error if the text at an offset, or the word before it, is another tool's notation."""
    near = [word for word in _WORDS.finditer(text) if word.start() <= offset][-2:]
    for word in near[::-1]:
        if text[word.end() : offset].strip():
            continue  # other text stands between them
        for spelling in (word[0], word[0].lower(), word[0][:1]):
            if ours := _FOREIGN.get(spelling):
                what = f"{word[0][: len(spelling)]!r} is another notation"
                return FormulaError(what, text, word.start(), len(spelling), f"write {ours}")
    return None


def _meaningless(text: str, offset: int) -> FormulaError:
    if foreign := _in_another_notation(text, offset):
        return foreign
    if text[offset] in "{^" and re.search(r"\b[XFGU]_?$", text[:offset]):
        what = f"{text[offset]!r} is another notation"
        ours = "X X at(A)" if text[offset] == "^" else "F[<=60s] at(A)"
        return FormulaError(what, text, offset, 1, f"write {ours}")
    if text[offset] == "[" and re.search(r"\bF\s*$", text[:offset]):
        what = "the [ of a time bound has no ]"
        return FormulaError(what, text, offset, 1, "write F[<=60s] at(A)")
    return FormulaError(f"{text[offset]!r} has no meaning in a formula", text, offset, 1, _NOTATION)


def _explained(misfit: Misfit, text: str) -> FormulaError:
    offset, word = misfit.offset, misfit.word
    accepted = misfit.expected
    hint = next((f"expected {words}" for terminal, words in _EXPECTED if terminal in accepted), "")
    if misfit.kind == END:
        return FormulaError("the formula ends too early", text, offset, 1, hint)
    if foreign := _in_another_notation(text, offset):
        return foreign
    if misfit.kind in ("BOUND", "LIMIT"):
        what, hint = bound_parsing.misplaced(misfit.kind, word, text[:offset])
        return FormulaError(what, text, offset, len(word), hint)
    if misfit.kind == "NUMBER":
        return _meaningless(text, offset)
    if re.search(rf"\b{AT}\s*$", text[:offset], re.IGNORECASE) and misfit.kind == "NAME":
        hint = f"write {_canonical(AT, [word])}"
    glued = re.search(r"\b[XFG]{2,}\s*$", text[:offset])
    if glued:
        operators = glued.group().strip()
        what = f"{operators!r} is read as a proposition"
        advice = f"did you mean {' '.join(operators)!r}?"
        return FormulaError(what, text, glued.start(), len(operators), advice)
    return FormulaError(f"unexpected {word!r}", text, offset, len(word), hint)


def atom(text: str) -> Formula:
    """The formula of a single proposition. Raises FormulaError for any other text.

    >>> str(atom("at( A )"))
    'at(A)'
    """
    formula = parse(text)
    if formula.operator is not Operator.ATOM:
        raise FormulaError(
            "not a proposition", text, 0, len(text), "a proposition looks like at(A)"
        )
    return formula
