"""Bounds in time as they are written, read and printed, and where they may not stand."""

from __future__ import annotations

import pytest

from companion.errors import FormulaError
from companion.ltl.parser import atom, occurrences, parse, parse_line
from companion.ltl.time_bounds import Response, Revisit, TimeBound, Within
from companion.ltl.timed_formula import TimedFormula, parts, untimed

AT_A = atom("at(A)")


@pytest.mark.parametrize(
    ("text", "bound", "printed"),
    [
        ("F[<=60s] at(A)", Within(AT_A, 60_000), "F[<=60s] at(A)"),
        ("F [ <= 1.5 min ]at(A)", Within(AT_A, 90_000), "F[<=90s] at(A)"),
        ("F[<=9.25s](a | !b)", Within(parse("a | !b"), 9250), "F[<=9.25s] (a | !b)"),
        ("((F[<=9s] a))", Within(atom("a"), 9000), "F[<=9s] a"),
        (
            "G (a -> F[<=90s] at(A))",
            Response(AT_A, 90_000, atom("a")),
            "G(a -> F[<=90s] at(A))",
        ),
        (
            "G((a -> b) -> F[<=2min] (c & d))",
            Response(parse("c & d"), 120_000, parse("a -> b")),
            "G((a -> b) -> F[<=120s] (c & d))",
        ),
        ("revisit(A)<=2 min", Revisit(AT_A, 120_000), "revisit(A) <= 120 s"),
        ("revisit( at( A ) ) <= 120s", Revisit(AT_A, 120_000), "revisit(A) <= 120 s"),
        ("revisit(F) <= 120 s", Revisit(atom("at(F)"), 120_000), "revisit(F) <= 120 s"),
        ("revisit((a)) <= 9 s", Revisit(atom("a"), 9000), "revisit((a)) <= 9 s"),
        (
            "revisit(at(A) | a) <= 9 s",
            Revisit(parse("at(A) | a"), 9000),
            "revisit(at(A) | a) <= 9 s",
        ),
    ],
)
def test_a_bound_is_read_and_printed(text: str, bound: TimeBound, printed: str) -> None:
    line = parse_line(text)
    assert line == TimedFormula((bound,))
    assert str(line) == printed
    assert parse_line(printed) == line


def test_a_line_has_bounded_and_other_parts() -> None:
    line = parse_line("revisit(A) <= 9 s & (G (a & F b) & F[<=60s] c)")
    assert str(line) == "revisit(A) <= 9 s & G(a & F b) & F[<=60s] c"
    assert [(str(part), str(bound)) for part, bound in parts(line)] == [
        ("G F at(A)", "revisit(A) <= 9 s"),
        ("G a", "None"),
        ("G F b", "None"),
        ("F c", "F[<=60s] c"),
    ]
    assert untimed(line) is parse("G F at(A) & G (a & F b) & F c")
    assert str(parse_line("(a <-> b) & F[<=9s] c")) == "(a <-> b) & F[<=9s] c"


def test_a_line_without_bounds_is_a_formula() -> None:
    assert parse_line("G F at(A)") is parse("G F at(A)")
    assert parse_line("F revisit <-> a") is parse("F revisit <-> a")  # a name as any other


def test_all_mentions_are_found() -> None:
    text = "revisit(A) <= 9 s & G(a -> F[<=2 min] at(B)) & revisit(b | true) <= 9 s"
    assert [(name, text[at : at + length]) for name, at, length in occurrences(text)] == [
        ("at(A)", "A"),
        ("a", "a"),
        ("at(B)", "at(B)"),
        ("b", "b"),
    ]


WHOLE_LINE = "time bounds stand at F and G (... -> F) of a whole line only"


@pytest.mark.parametrize(
    ("text", "what", "underlined"),
    [
        ("X F[<=60s] a", WHOLE_LINE, "[<=60s]"),
        ("!F[<=60s] a", WHOLE_LINE, "[<=60s]"),
        ("b | F[<=60s] a", WHOLE_LINE, "[<=60s]"),
        ("b U F[<=60s] a", WHOLE_LINE, "[<=60s]"),
        ("b -> F[<=60s] a", WHOLE_LINE, "[<=60s]"),
        ("b <-> F[<=60s] a", WHOLE_LINE, "[<=60s]"),
        ("G F[<=60s] a", WHOLE_LINE, "[<=60s]"),
        ("G(b & (c -> F[<=60s] a))", WHOLE_LINE, "[<=60s]"),
        ("G(b -> F[<=60s] a & c)", WHOLE_LINE, "[<=60s]"),
        ("G(b -> X F[<=60s] a)", WHOLE_LINE, "[<=60s]"),
        ("G revisit(A) <= 60 s", WHOLE_LINE, "<= 60 s"),
        ("G(b -> revisit(A) <= 60 s)", WHOLE_LINE, "<= 60 s"),
        ("F F[<=60s] a", WHOLE_LINE, "[<=60s]"),
        ("F[<=60s] F a", "a time bound is about facts, and F a has", "[<=60s]"),
        ("G(X b -> F[<=60s] a)", "a time bound is about facts, and X b has", "[<=60s]"),
        ("revisit(a U b) <= 9 s", "a time bound is about facts, and a U b has", "<= 9 s"),
        ("revisit(A)", "revisit has no bound", "revisit"),
        ("revisit(A) < 60 s", "a time bound is <= a time", "< 60 s"),
        ("F[60s] a", "a time bound is <= a time", "[60s]"),
        ("F[<=60] a", "the time has no unit", "[<=60]"),
        ("F[<=60ms] a", "the time has the unit ms", "[<=60ms]"),
        ("revisit(A) <= 2 h", "the time has the unit h", "<= 2 h"),
        ("F[<=0s] a", "no plan can be held to 0 s", "[<=0s]"),
        ("F[<=-5s] a", "no plan can be held to -5 s", "[<=-5s]"),
        ("F[<=2s] a", "no plan can be held to 2 s", "[<=2s]"),
        ("F[<=1441min] a", "no plan can be held to 1441 min", "[<=1441min]"),
        ("F[<=1e3s] a", "[<=1e3s] is not a bound in time", "[<=1e3s]"),
        ("F[] a", "[] is not a bound in time", "[]"),
        ("F[<=60s a", "the [ of a time bound has no ]", "["),
        ("G[<=60s] a", "a time bound stands after F only", "[<=60s]"),
        ("F a <= 60 s", "a limit in time follows revisit(...) only", "<= 60 s"),
    ],
)
def test_a_wrong_bound_is_told_where_it_stands(text: str, what: str, underlined: str) -> None:
    with pytest.raises(FormulaError) as error:
        parse_line(text)
    assert error.value.what.startswith(what)
    at, length = error.value.offset, error.value.length
    assert text[at : at + length] == underlined
    assert error.value.advice


def test_only_lines_of_a_task_have_bounds() -> None:
    with pytest.raises(FormulaError, match="this cannot have a time bound") as error:
        parse("G (a -> F[<=60s] b)")
    line, without = "soon: G(a -> F[<=60s] b)", "G(a -> F b)"
    assert (
        error.value.advice
        == f"a mission has it in a line under task:, {line}; here write {without}"
    )


@pytest.mark.parametrize(
    ("limit_ms", "planned_ms"), [(3000, 1000), (10_000, 8000), (40_000, 38_000), (60_001, 57_000)]
)
def test_plans_keep_a_margin(limit_ms: int, planned_ms: int) -> None:
    assert Within(AT_A, limit_ms).planned_ms == planned_ms
