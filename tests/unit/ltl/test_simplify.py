"""The laws of simplification, each on its smallest example; meaning is tested as a property."""

from __future__ import annotations

import pytest

from companion.ltl.formula import negation_normal_form
from companion.ltl.parser import parse
from companion.ltl.simplify import simplified


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("X true & X X true | F false", "true"),
        ("a & !a", "false"),
        ("F F a", "F a"),
        ("G G a", "G a"),
        ("a U (a U b)", "a U b"),
        ("a R (a R b)", "a R b"),
        ("F(a U b)", "F b"),
        ("G(a R b)", "G b"),
        ("F G F a", "G F a"),
        ("G F G a", "F G a"),
        ("X G F a", "G F a"),
        ("a U G F b", "G F b"),
        ("F X a", "X F a"),
        ("X a U X b", "X(a U b)"),
        ("F a | F b", "F(a | b)"),
        ("G a & G b", "G(a & b)"),
        ("G F a | G F b", "G F(a | b)"),
        ("F G a & F G b", "F G(a & b)"),
        ("(a U c) & (b U c)", "(a & b) U c"),
        ("(a R c) | (b R c)", "(a | b) R c"),
        ("a U (b | F c)", "a U b | F c"),
        ("F(a & G F b)", "F a & G F b"),
        ("G F(a & F b)", "G(F a & F b)"),
        ("F G(a | G b)", "F(G a | G b)"),
        ("F G a | G F b", "F(G a | G F b)"),
        ("X a | X b", "X(a | b)"),
        ("X a & X b", "X(a & b)"),
        ("G a | a U b", "b R (a | b)"),
        ("F a & a R b", "b U (a & b)"),
        ("G !a | F(a & F b)", "(a & F b) R (!a | F b)"),
        ("G(a & X F b)", "G(a & F b)"),
        ("F(a | X G b)", "F(a | G b)"),
        ("G(a & F(b & X F c))", "G(a & F b & F c)"),
        ("G(t | F p)", "G(t | F p)"),
        (
            "G(t | F p) & G(t | F q)",
            "F(F p & F q & X G t | G (F p & F q)) | G t",
        ),
        ("b | (a U b)", "a U b"),
        ("b & (a U b)", "b"),
        ("a | (a & b)", "a"),
        ("a & (!a | b)", "a & b"),
        ("a | G(a & b)", "a"),
        ("F a & !(F a)", "false"),
        ("!b U b", "F b"),
        ("F b U b", "F b"),
        ("(a & b) U (a U c)", "a U c"),
        ("a U ((a & b) U c)", "a U c"),
        ("(a U b) U b", "a U b"),
        ("(a & !b) U b", "a U b"),
        ("a U (b | G a)", "b R (a | b)"),
        ("a R (b & F a)", "b U (a & b)"),
        ("G F a U X b", "X(G F a U b)"),
        ("G a & F(b & X a)", "G a & F b"),
        ("F a | G(b | a)", "F a | G b"),
        ("G(F a & F(a & F b))", "G(F a & F b)"),
        ("G F(a & G b)", "G F a & F G b"),
        ("F G(a U b)", "F G((a | b) & F b)"),
        ("G F(a R b)", "G F(a & b | G b)"),
        ("G(a U b)", "G((a | b) & F b)"),
        ("G F(X a | F b)", "G F(a | b)"),
        ("G F(X X a | F b)", "G F(a | b)"),
        ("F G(a & X X b)", "F G(a & b)"),
        ("G F(a | G F b)", "G F(a | b)"),
        ("G(a | G(a | b))", "G(a | b)"),
        ("F(a & F(a & b))", "F(a & b)"),
        ("a | X F a", "F a"),
        ("a & X G a", "G a"),
        ("X !b U b", "b"),
        ("X b R !b", "!b"),
        ("G a W b", "G a | b"),
        ("a U (a & F b)", "a & F b"),
        ("F G a & G F(a & b)", "F G a & G F b"),
        ("G F a | F G(a & b)", "G F a"),
        ("G F b & G(c -> X(a U b))", "G(F b & (c -> X(a W b)))"),
        ("(a U c | F d) & (b | c) | F d", "(a U c) & (b | c) | F d"),
    ],
)
def test_law(text: str, expected: str) -> None:
    assert simplified(negation_normal_form(parse(text))) is negation_normal_form(parse(expected))


@pytest.mark.slow
def test_depth_is_limited_by_memory_alone() -> None:
    depth = 2_000
    deep = negation_normal_form(parse("a U (b & X(" * depth + "c" + "))" * depth))
    assert simplified(deep) is deep
    assert simplified(negation_normal_form(parse("F " * depth + "a"))) is simplified(
        negation_normal_form(parse("F a"))
    )
