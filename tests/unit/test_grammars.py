"""Texts are read by grammars: values, and the place where a text stops to fit."""

from __future__ import annotations

import pytest
from lark import Token, Transformer

from companion.errors import FormulaError
from companion.grammars import END, Grammar, Misfit, error_at
from companion.mission import calls


class Names(Transformer[Token, list[str]]):
    """Makes a list of a call; refuses the name `bad`."""

    def call(self, tokens: list[Token]) -> list[str]:
        if tokens[0] == "bad":
            raise error_at(tokens[0], "bad is not allowed", "write good")
        return [str(token) for token in tokens]

    def by_position(self, tokens: list[Token]) -> Token:
        return tokens[0]


CALLS = Grammar("call", "calls.lark", calls.__file__, Names(), ["call"], most=40)


def test_a_text_that_fits_is_the_value_of_its_builder() -> None:
    assert CALLS.read("fly( to )") == ["fly", "to"]


@pytest.mark.parametrize(
    ("text", "misfit"),
    [
        ("fly to", (4, "to", "NAME", {"_OPEN"})),
        ("fly(to) ", (None)),
        ("fly", (3, "", END, {"_OPEN"})),
        ("fly(  ", (4, "", END, None)),
        ('fly("to)', (4, '"', "", None)),
    ],
)
def test_a_misfit_is_where_the_text_stops_to_fit(
    text: str, misfit: tuple[int, str, str, set[str] | None] | None
) -> None:
    found = CALLS.read(text)
    if misfit is None:
        assert found == ["fly", "to"]
        return
    assert isinstance(found, Misfit)
    offset, word, kind, expected = misfit
    assert (found.offset, found.word, found.kind) == (offset, word, kind)
    assert expected is None or found.expected == expected


def test_an_error_of_the_builder_gets_the_text() -> None:
    with pytest.raises(FormulaError) as refused:
        CALLS.read("  bad()")
    assert (refused.value.text, refused.value.offset, refused.value.length) == ("  bad()", 2, 3)


def test_a_long_text_is_not_read() -> None:
    with pytest.raises(FormulaError, match="a call has at most 40 characters, this one has 41"):
        CALLS.read("x" * 41)
