"""Reads short texts by grammars of lark, and says where a text does not fit.

Formulas, calls of steps and conditions of events each have a grammar, in a file beside the module
that says what a text means. A text that does not fit is a value: each language explains it in its
own words.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Generic, TypeVar

from lark import Lark, Token, Transformer
from lark.exceptions import UnexpectedCharacters, UnexpectedToken
from lark.lexer import BasicLexer, LexerThread

from companion.errors import FormulaError

END = "$END"
"""The kind of token that stands for the end of a text."""

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Misfit:
    """Where a text stops to fit a grammar.

    Attributes:
        offset: of the first token that does not fit, or the end of the text if it ends too early.
        word: that token; one character if no token begins with it, "" at the end.
        kind: the kind of the token; "" for a character that begins no token.
        expected: the kinds of tokens that would fit.
    """

    offset: int
    word: str
    kind: str
    expected: frozenset[str]


class Grammar(Generic[T]):
    """A language of short texts; its grammar is opened when the first text is read.

    Args:
        name: what one of its texts is called, e.g. formula.
        file: the name of the grammar.
        beside: the path of a module in the same folder.
        builder: makes the value of a text, with one method for each rule.
        starts: the rule that a whole text is; others after it are never read, but their words are
            known where a text does not fit.
        most: the greatest number of characters.
        is_contextual: whether a word is read as what may stand there; if not, a word is read alike
            everywhere.
    """

    def __init__(
        self,
        name: str,
        file: str,
        beside: str,
        builder: Transformer[Token, T],
        starts: Sequence[str] = ("start",),
        most: int = 10_000,
        is_contextual: bool = True,
    ) -> None:
        self._name = name
        self._most = most
        self._file = file
        self._beside = beside
        self._builder = builder
        self._starts = list(starts)
        self._lexer = "contextual" if is_contextual else "basic"

    @cached_property
    def _parser(self) -> Lark:
        return Lark.open(
            self._file,
            rel_to=self._beside,
            parser="lalr",
            lexer=self._lexer,
            transformer=self._builder,
            start=self._starts,
        )

    @cached_property
    def _lexer_of_all(self) -> BasicLexer:
        return BasicLexer(self._parser.lexer_conf)  # Lark.lex makes one for each text

    def read(self, text: str) -> T | Misfit:
        """The value of a text, or where the text does not fit.

        Raises:
            FormulaError: the text is too long, or the builder refuses a part of it.
        """
        self.refuse_more("characters", len(text), self._most, text)
        try:
            value: T = self._parser.parse(text, self._starts[0])  # type: ignore[assignment]
        except UnexpectedCharacters as error:
            offset = error.pos_in_stream or 0
            return Misfit(offset, text[offset], "", frozenset(error.allowed or ()))
        except UnexpectedToken as error:
            return _misfit(error, text)
        except FormulaError as error:  # the builder does not know the text
            raise FormulaError(error.what, text, error.offset, error.length, error.advice) from None
        return value

    def refuse_more(self, of_what: str, count: int, most: int, text: str) -> None:
        """Refuses a text that has too much of something, because it would take long to read.

        Raises:
            FormulaError: with the limit.
        """
        if count > most:
            what = f"a {self._name} has at most {most:,} {of_what}, this one has {count:,}"
            excerpt = f"{text[:40]} ..."
            raise FormulaError(what, excerpt, 0, len(excerpt), "split it into several")

    def tokens(self, text: str) -> Iterator[Token]:
        """The tokens of a text that fits."""
        words = LexerThread.from_text(self._lexer_of_all, text)
        found: Iterator[Token] = words.lex(None)  # type: ignore[no-untyped-call]
        return found


def _misfit(error: UnexpectedToken, text: str) -> Misfit:
    expected = frozenset(error.accepts or error.expected)
    if error.token.type == END:
        return Misfit(len(text.rstrip()), "", END, expected)
    return Misfit(error.token.start_pos or 0, str(error.token), error.token.type, expected)


def error_at(token: Token, what: str, advice: str, text: str = "") -> FormulaError:
    """An error that underlines a token; `Grammar.read` adds the text, which no builder knows."""
    return FormulaError(what, text, *span(token, token), advice)


def span(first: Token, last: Token) -> tuple[int, int]:
    """Offset and length of the text from one token to another."""
    assert first.start_pos is not None and last.end_pos is not None
    return first.start_pos, last.end_pos - first.start_pos
