"""Formulas are read as the precedences say, printed so that they read back, and never recurse."""

from __future__ import annotations

import gc
import pickle

import pytest

from companion.errors import FormulaError
from companion.ltl.conjuncts import conjuncts
from companion.ltl.formula import (
    FALSE,
    TRUE,
    Operator,
    always,
    atoms,
    conjoin,
    disjoin,
    eventually,
    implies,
    negate,
    negation_normal_form,
    next_,
    release,
    subformulas,
    until,
    weak_until,
)
from companion.ltl.parser import atom, occurrences, parse

DEPTH = 5_000


def test_constructors_and_text_give_the_same_object() -> None:
    a, b = atom("at(A)"), atom("b")
    assert parse("G(at(A) -> X b)") is always(implies(a, next_(b)))
    assert parse("!at( A ) | F b") is disjoin(negate(a), eventually(b))
    assert parse("(at(A) U b) R (at(A) W b)") is release(until(a, b), weak_until(a, b))
    assert (conjoin(), disjoin(), conjoin(a), negate(negate(a))) == (TRUE, FALSE, a, a)


@pytest.mark.parametrize(
    ("text", "explicit"),
    [
        ("a <-> b -> c | d & e U !f", "a <-> (b -> (c | (d & (e U (!f)))))"),
        ("a -> b -> c", "a -> (b -> c)"),
        ("a <-> b <-> c", "a <-> (b <-> c)"),
        ("a U b R c W d", "a U (b R (c W d))"),
        ("! X F G a U b", "(!(X(F(G a)))) U b"),
        ("a && b || c", "(a & b) | c"),
        ("Foo & Xa & true_", "((Foo) & (Xa) & (true_))"),
    ],
)
def test_precedence(text: str, explicit: str) -> None:
    assert parse(text) is parse(explicit)


@pytest.mark.parametrize(
    "text",
    [
        "G(at(A) | F targetFound)",
        "a & (b & c)",
        "(a -> b) -> c",
        "(a U b) U c",
        "!(a & b) | !!a",
        "trans_ok(A, B) & at(F)",
        "X X true <-> false",
    ],
)
def test_prints_with_as_few_parentheses_as_possible(text: str) -> None:
    assert str(parse(text)) == text


@pytest.mark.parametrize(
    ("text", "underlined", "what", "advice"),
    [
        ("F at(A) b", "b", "unexpected 'b'", "or the end"),
        ("G (a & | b)", "|", "unexpected '|'", "expected a proposition"),
        ("a & U", "U", "unexpected 'U'", "expected a proposition"),
        ("F at(A,)", ")", "unexpected ')'", "the name of an argument"),
        ("at(A B)", "B", "unexpected 'B'", "a comma or )"),
        ("a)", ")", "unexpected ')'", "or the end"),
        ("F a = b", "=", "'=' has no meaning", "a formula is made of"),
        ("GF p", "GF", "'GF' is read as a proposition", "did you mean 'G F'?"),
        ("a &\n  & b", "&", "unexpected '&'", "expected a proposition"),
    ],
)
def test_error_underlines_the_token(text: str, underlined: str, what: str, advice: str) -> None:
    with pytest.raises(FormulaError) as caught:
        parse(text)
    error = caught.value
    assert text[error.offset : error.offset + error.length] == underlined
    assert what in error.what
    assert advice in error.advice
    _, line, caret = str(error).splitlines()
    start = caret.index("^")
    assert line[start : start + caret.count("^")] == underlined


@pytest.mark.parametrize(
    ("text", "advice"), [("a U ", "a proposition"), ("(a | b", "or )"), ("at(A", "a comma or )")]
)
def test_error_at_the_end(text: str, advice: str) -> None:
    with pytest.raises(FormulaError, match="ends too early") as caught:
        parse(text)
    assert caught.value.offset == len(text.rstrip())
    assert advice in caught.value.advice


def test_occurrences_point_at_each_mention() -> None:
    text = "G(at( A ) -> F(done)) & trans_ok(A,F) U at(A)"
    found = occurrences(text)
    assert [name for name, _, _ in found] == ["at(A)", "done", "trans_ok(A, F)", "at(A)"]
    assert [text[offset : offset + length] for _, offset, length in found] == [
        "at( A )",
        "done",
        "trans_ok(A,F)",
        "at(A)",
    ]


def test_atom_refuses_what_is_not_a_proposition() -> None:
    with pytest.raises(FormulaError, match="not a proposition"):
        atom("a & b")


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [
        "!" * DEPTH + "a",
        pytest.param("X " * DEPTH + "a", marks=pytest.mark.long),
        "(a & " * DEPTH + "b" + ")" * DEPTH,
        pytest.param("a U " * DEPTH + "b", marks=pytest.mark.long),
        pytest.param("(" * DEPTH + "a" + " W b)" * DEPTH, marks=pytest.mark.long),
        pytest.param("a & " * DEPTH + "b", marks=pytest.mark.long),
    ],
    ids=["not", "next", "and", "right", "left", "chain"],
)
def test_depth_is_limited_by_memory_alone(text: str) -> None:
    formula = parse(text)
    assert parse(str(formula)) is formula
    assert atoms(formula) <= {"a", "b"}
    assert negation_normal_form(negate(formula)) is not formula
    assert conjuncts(formula)


@pytest.mark.slow
def test_interning_keeps_no_garbage() -> None:
    import companion.ltl.formula as module

    gc.collect()
    before = len(module._interned)
    formula = parse("X " * 1000 + "only_here")
    assert len(module._interned) > before + 1000
    del formula
    gc.collect()
    assert len(module._interned) <= before


def test_a_pickled_copy_is_the_same_object() -> None:
    formula = parse("G(at(A) -> X b)")
    assert pickle.loads(pickle.dumps(formula)) is formula


def test_normal_form_uses_seven_operators() -> None:
    allowed = {"true", "false", "atom", "!", "&", "|", "X", "U", "R"}
    normal = negation_normal_form(parse("!(a <-> F b) & !(G a W X(b -> a))"))
    for node in subformulas(normal):
        assert node.operator.value in allowed
        if node.operator is Operator.NOT:
            assert node.operands[0].operator is Operator.ATOM


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        ("G F a & G b | F c | X d", ["G F a | F c | X d", "G b | F c | X d"]),
        ("!F c -> G F a & (b U c & F d)", ["!F c -> G F a", "!F c -> b U c", "!F c -> F d"]),
        ("F c | F a & X b | X d", ["F c | F a | X d", "F c | X b | X d"]),
        ("G c | G F a & G F b", None),
        ("G F c -> G F a & G F b", None),
        ("a & b | F c", None),
        ("G(G F a & G F b | F c)", None),
        ("G F a & G F b -> F c", None),
    ],
)
def test_what_holds_unless_something_happens_is_split(text: str, parts: list[str] | None) -> None:
    assert [str(part) for part in conjuncts(parse(text))] == (parts or [str(parse(text))])


def test_conjuncts_of_the_paper() -> None:
    task = parse(
        "G((F at(A) | t) & (F at(B) | t)) & G((t | r) -> F r)"
        " & G(r -> X at(Home)) & G G(F at(A) | t)"
    )
    assert [str(part) for part in conjuncts(task)] == [
        "G(F at(A) | t)",
        "G(F at(B) | t)",
        "G(t | r -> F r)",
        "G(r -> X at(Home))",
    ]
