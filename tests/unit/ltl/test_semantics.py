"""The direct semantics, against words whose verdict is plain to see."""

from __future__ import annotations

import pytest

from companion.ltl.parser import parse
from companion.ltl.semantics import accepts, holds
from companion.ltl.translate import translate

Letter = frozenset[str]


def word(text: str) -> list[Letter]:
    """The word {a, b} {} {c} is written `ab - c`."""
    return [frozenset(letters.replace("-", "")) for letters in text.split()]


@pytest.mark.parametrize(
    ("formula", "prefix", "loop", "verdict"),
    [
        ("a & !b", "a", "-", True),
        ("X a", "- a", "-", True),
        ("X X X a", "- -", "- a", True),
        ("X X X X a", "- -", "- a", False),
        ("a U b", "a a", "b", True),
        ("a U b", "a - ", "b", False),
        ("a U b", "", "a", False),
        ("a W b", "", "a", True),
        ("a R b", "b b ab", "-", True),
        ("a R b", "b b a", "-", False),
        ("a R b", "", "b", True),
        ("F a", "- -", "- - a", True),
        ("G F a", "a a a", "-", False),
        ("G F a", "", "- a", True),
        ("F G a", "", "- a", False),
        ("F G a", "- -", "a", True),
        ("G(a -> X b)", "a", "ab b", True),
        ("G(a -> X b)", "a", "ab -", False),
        ("a <-> b", "ab", "-", True),
        ("true | false", "", "-", True),
        ("a | b | c", "c", "-", True),
    ],
)
def test_verdict(formula: str, prefix: str, loop: str, verdict: bool) -> None:
    assert holds(parse(formula), word(prefix), word(loop)) is verdict
    assert accepts(translate(parse(formula)), word(prefix), word(loop)) is verdict


def test_until_does_not_ask_for_both_at_once() -> None:
    """The paper prints i <= j <= k; with it this word would not satisfy a U b."""
    assert holds(parse("a U b"), word("a"), word("b"))


def test_the_loop_is_never_empty() -> None:
    with pytest.raises(ValueError, match="loop"):
        holds(parse("a"), word("a"), [])
    with pytest.raises(ValueError, match="loop"):
        accepts(translate(parse("a")), word("a"), [])
