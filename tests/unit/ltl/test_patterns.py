"""Mission patterns mean what the paper's table says, and errors point at the wrong argument."""

from __future__ import annotations

import math
import shutil
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.errors import FormulaError, MissionError
from companion.ltl.formula import FALSE, atoms
from companion.ltl.parser import atom, occurrences, parse
from companion.ltl.patterns import PATTERNS
from companion.ltl.semantics import Letter, holds
from companion.mission.loader import load_mission

MISSIONS = Path(__file__).parents[3] / "missions"


def word(text: str) -> list[Letter]:
    """The word {at(A), p} {} {at(B)} is written `Ap - B`."""
    return [
        frozenset(f"at({name})" if name.isupper() else name for name in letters.replace("-", ""))
        for letters in text.split()
    ]


SCHEMES = {
    "visit(A, B)": "F at(A) & F at(B)",
    "visit(A, B, C)": "F at(A) & F at(B) & F at(C)",
    "sequenced_visit(A, B)": "F(at(A) & F at(B))",
    "sequenced_visit(A, B, C)": "F(at(A) & F(at(B) & F at(C)))",
    "ordered_visit(A, B)": "F(at(A) & F at(B)) & (!at(B) U at(A))",
    "ordered_visit(A, B, C)": (
        "F(at(A) & F(at(B) & F at(C))) & (!at(B) U at(A)) & (!at(C) U at(B))"
    ),
    "strict_ordered_visit(A, B)": (
        "F(at(A) & F at(B)) & (!at(B) U at(A)) & (!at(A) U (at(A) & X(!at(A) U at(B))))"
    ),
    "strict_ordered_visit(A, B, C)": (
        "F(at(A) & F(at(B) & F at(C))) & (!at(B) U at(A)) & (!at(C) U at(B))"
        "& (!at(A) U (at(A) & X(!at(A) U at(B)))) & (!at(B) U (at(B) & X(!at(B) U at(C))))"
    ),
    "fair_visit(A, B)": (
        "F at(A) & F at(B) & G(at(A) -> X(!at(A) W at(B))) & G(at(B) -> X(!at(B) W at(A)))"
    ),
    "fair_visit(A, B, C)": (
        "F at(A) & F at(B) & F at(C) & G(at(A) -> X(!at(A) W at(B)))"
        "& G(at(B) -> X(!at(B) W at(C))) & G(at(C) -> X(!at(C) W at(A)))"
    ),
    "patrolling(A, B)": "G F at(A) & G F at(B)",
    "patrolling(A, B, C)": "G F at(A) & G F at(B) & G F at(C)",
    "sequenced_patrolling(A, B)": "G F(at(A) & F at(B))",
    "sequenced_patrolling(A, B, C)": "G F(at(A) & F(at(B) & F at(C)))",
    "ordered_patrolling(A, B)": (
        "G F(at(A) & F at(B)) & (!at(B) U at(A))"
        "& G(at(B) -> X(!at(B) U at(A))) & G(at(A) -> X(!at(A) U at(B)))"
    ),
    "ordered_patrolling(A, B, C)": (
        "G F(at(A) & F(at(B) & F at(C))) & (!at(B) U at(A)) & (!at(C) U at(B))"
        "& G(at(B) -> X(!at(B) U at(A))) & G(at(C) -> X(!at(C) U at(B)))"
        "& G(at(A) -> X(!at(A) U at(C)))"
    ),
    "strict_ordered_patrolling(A, B)": (
        "G F(at(A) & F at(B)) & (!at(B) U at(A))"
        "& G(at(B) -> X(!at(B) U at(A))) & G(at(A) -> X(!at(A) U at(B)))"
        "& G(at(A) -> X(!at(A) U at(B)))"
    ),
    "strict_ordered_patrolling(A, B, C)": (
        "G F(at(A) & F(at(B) & F at(C))) & (!at(B) U at(A)) & (!at(C) U at(B))"
        "& G(at(B) -> X(!at(B) U at(A))) & G(at(C) -> X(!at(C) U at(B)))"
        "& G(at(A) -> X(!at(A) U at(C)))"
        "& G(at(A) -> X(!at(A) U at(B))) & G(at(B) -> X(!at(B) U at(C)))"
    ),
    "fair_patrolling(A, B)": (
        "G F at(A) & G F at(B) & G(at(A) -> X(!at(A) W at(B))) & G(at(B) -> X(!at(B) W at(A)))"
    ),
    "fair_patrolling(A, B, C)": (
        "G F at(A) & G F at(B) & G F at(C) & G(at(A) -> X(!at(A) W at(B)))"
        "& G(at(B) -> X(!at(B) W at(C))) & G(at(C) -> X(!at(C) W at(A)))"
    ),
    "past_avoidance(A, p)": "!at(A) U p",
    "global_avoidance(A)": "G !at(A)",
    "global_avoidance(A, B, C)": "G !at(A) & G !at(B) & G !at(C)",
    "future_avoidance(at(B), A)": "G(at(B) -> G !at(A))",
    "upper_restricted_avoidance(A, 1)": "!F(at(A) & X F at(A))",
    "upper_restricted_avoidance(A, 2)": "!F(at(A) & X F(at(A) & X F at(A)))",
    "lower_restricted_avoidance(A, 1)": "F at(A)",
    "lower_restricted_avoidance(A, 3)": "F(at(A) & X F(at(A) & X F at(A)))",
    "exact_restricted_avoidance(A, 1)": "!at(A) U (at(A) & X G !at(A))",
    "exact_restricted_avoidance(A, 2)": "!at(A) U (at(A) & X(!at(A) U (at(A) & X G !at(A))))",
    "instantaneous_reaction(p, q)": "G(p -> q)",
    "delayed_reaction(p, trans_ok(A, B))": "G(p -> F trans_ok(A, B))",
    "prompt_reaction(p, q)": "G(p -> X q)",
    "bound_reaction(p, q)": "G(p <-> q)",
    "bound_delay(p, q)": "G(p <-> X q)",
    "wait(A, p)": "at(A) U p",
}
"""The paper's formula schemes, instantiated by hand."""


@pytest.mark.parametrize("text", SCHEMES)
def test_expansion_is_the_scheme(text: str) -> None:
    formula = parse(text)
    assert formula is parse(SCHEMES[text])
    assert parse(str(formula)) is formula


MEANINGS = [
    ("visit(A, B)", ("B - A", "-"), ("A A", "-")),
    ("sequenced_visit(A, B)", ("B A B", "-"), ("B A", "-")),
    ("ordered_visit(A, B)", ("A A B A", "-"), ("B A B", "-")),
    ("strict_ordered_visit(A, B)", ("A - B A", "-"), ("A A B", "-")),
    ("fair_visit(A, B)", ("B A B", "-"), ("A - A B", "-")),
    ("patrolling(A, B)", ("-", "B B A"), ("A B A B", "A")),
    ("sequenced_patrolling(A, B)", ("B", "- A B"), ("A B", "B")),
    ("ordered_patrolling(A, B, C)", ("-", "A B C -"), ("-", "A C B")),
    ("strict_ordered_patrolling(A, B, C)", ("A B C", "A B C"), ("A B C", "A B B C")),
    ("fair_patrolling(A, B)", ("B", "A B"), ("", "A A B")),
    ("past_avoidance(A, p)", ("- p A", "-"), ("- A p", "-")),
    ("global_avoidance(A, B)", ("C", "-"), ("C", "- B")),
    ("future_avoidance(p, A)", ("A p", "-"), ("p - A", "-")),
    ("upper_restricted_avoidance(A, 2)", ("A - A", "-"), ("A A - A", "-")),
    ("lower_restricted_avoidance(A, 2)", ("A A - A", "-"), ("- A", "-")),
    ("exact_restricted_avoidance(A, 2)", ("A - A", "-"), ("A A - A", "-")),
    ("exact_restricted_avoidance(A, 3)", ("A - A A", "-"), ("A - A", "-")),
    ("instantaneous_reaction(p, q)", ("pq q", "-"), ("p q", "-")),
    ("delayed_reaction(p, q)", ("p - q", "-"), ("q p", "-")),
    ("prompt_reaction(p, q)", ("q p q", "-"), ("p - q", "-")),
    ("bound_reaction(p, q)", ("pq -", "pq"), ("pq q", "-")),
    ("bound_delay(p, q)", ("q p q", "-"), ("p q q", "-")),
    ("wait(A, p)", ("A A p", "-"), ("A - p", "-")),
]
"""A pattern, a word (prefix and loop) that satisfies it, and one that does not."""


@pytest.mark.parametrize(("text", "good", "bad"), MEANINGS)
def test_meaning(text: str, good: tuple[str, str], bad: tuple[str, str]) -> None:
    formula = parse(text)
    assert holds(formula, word(good[0]), word(good[1]))
    assert not holds(formula, word(bad[0]), word(bad[1]))


VISITS = st.lists(st.sampled_from(["A", "-"]), max_size=6)


@given(VISITS, st.sampled_from(["-", "A", "- A"]), st.integers(1, 9))
def test_restricted_avoidance_counts_visits(prefix: list[str], loop: str, count: int) -> None:
    visits = math.inf if "A" in loop else prefix.count("A")
    for bound, verdict in (
        ("upper", visits <= count),
        ("lower", visits >= count),
        ("exact", visits == count),
    ):
        formula = parse(f"{bound}_restricted_avoidance(A, {count})")
        assert holds(formula, word(" ".join(prefix)), word(loop)) is verdict


def test_every_pattern_is_tested() -> None:
    assert {text.partition("(")[0] for text in SCHEMES} == set(PATTERNS)
    assert {text.partition("(")[0] for text, _, _ in MEANINGS} == set(PATTERNS)


def test_a_pattern_is_an_operand_like_any_other() -> None:
    assert parse("!patrolling(A, B) | F p") is parse("!(G F at(A) & G F at(B)) | F p")
    assert parse("wait(A, p) U wait(B, q)") is parse("(at(A) U p) U (at(B) U q)")
    assert parse("X wait ( F , at( G ) )") is parse("X(at(F) U at(G))")


def test_a_bare_name_stays_a_proposition() -> None:
    assert atoms(parse("F wait")) == {"wait"}
    assert atoms(parse("wait(A, wait)")) == {"at(A)", "wait"}


def test_false_is_no_place() -> None:
    """Between brackets nothing is reserved: a place may be called false."""
    assert parse("wait(false, p)") is not FALSE
    assert atoms(parse("wait(false, p)")) == {"at(false)", "p"}


@pytest.mark.parametrize(
    ("text", "underlined", "what", "advice"),
    [
        ("F p & patrolling(A)", "patrolling", "cannot have 1 argument", "(place, place, ...)"),
        ("wait(A, p, q)", "wait", "cannot have 3 arguments", "write wait(place, condition)"),
        ("visit(A, at( B ))", "at( B )", "at(B) is not the name of a place", "write visit("),
        ("visit(A, 2)", "2", "2 is not the name of a place", "write visit("),
        ("wait(A, F)", "F", "F is not a proposition", "wait(place, condition)"),
        ("wait(A, true)", "true", "true is not a proposition", "wait(place, condition)"),
        ("wait(A, 3)", "3", "3 is not a proposition", "wait(place, condition)"),
        ("wait(A, visit(B, C))", "visit(B, C)", "visit(B, C) is not a prop", "wait(place"),
        ("lower_restricted_avoidance(A, B)", "B", "B is not a number from 1 to 9", "count"),
        ("lower_restricted_avoidance(A, 0)", "0", "0 is not a number from 1 to 9", "count"),
        ("lower_restricted_avoidance(A, 12)", "12", "12 is not a number from 1 to 9", "count"),
        ("wait(A, at(at(B)))", "(", "unexpected '('", "a comma or )"),
        ("wait(A, p & q)", "&", "unexpected '&'", "a comma or )"),
        ("wait(A, !p)", "!", "unexpected '!'", "the name of an argument"),
        ("F trans_ok(A, at(B))", "at(B)", "trans_ok cannot be at(B)", "the name of an argument"),
        ("F at(2)", "2", "an argument of at cannot be 2", "the name of an argument"),
        ("F 2", "2", "'2' has no meaning", "a formula is made of"),
        ("p\n& wait(A,\n  3)", "3", "3 is not a proposition", "wait(place, condition)"),
    ],
)
def test_error_underlines_the_argument(text: str, underlined: str, what: str, advice: str) -> None:
    with pytest.raises(FormulaError) as caught:
        parse(text)
    error = caught.value
    assert text[error.offset : error.offset + error.length] == underlined
    assert what in error.what
    assert advice in error.advice
    _, line, caret = str(error).splitlines()
    start = caret.index("^")
    assert line[start : start + caret.count("^")] == underlined


def test_occurrences_are_the_propositions_of_the_expansion() -> None:
    text = "wait( F , trans_ok(A,B) ) & lower_restricted_avoidance(C, 2) -> patrolling(A, A) | wait"
    found = occurrences(text)
    assert [(name, text[offset : offset + length]) for name, offset, length in found] == [
        ("at(F)", "F"),
        ("trans_ok(A, B)", "trans_ok(A,B)"),
        ("at(C)", "C"),
        ("at(A)", "A"),
        ("at(A)", "A"),
        ("wait", "wait"),
    ]
    assert [offset for _, offset, _ in found] == sorted({offset for _, offset, _ in found})


@pytest.mark.parametrize("text", [*SCHEMES, *(text for text, _, _ in MEANINGS)])
def test_occurrences_miss_nothing(text: str) -> None:
    assert {name for name, _, _ in occurrences(text)} == atoms(parse(text))


def test_a_pattern_is_not_a_proposition() -> None:
    with pytest.raises(FormulaError, match="not a proposition"):
        atom("wait(A, p)")


SEARCH = "G (F (at(A) | targetFound) & F (at(B) | targetFound) & F (at(C) | targetFound))"


@pytest.fixture
def surveillance(tmp_path: Path) -> Path:
    shutil.copytree(MISSIONS, tmp_path, dirs_exist_ok=True)
    return tmp_path / "surveillance.yaml"


def rewrite(path: Path, search: str) -> None:
    text = path.read_text(encoding="utf-8")
    assert SEARCH in text
    path.write_text(text.replace(SEARCH, search), encoding="utf-8")


def test_a_mission_may_use_patterns(surveillance: Path) -> None:
    rewrite(surveillance, "patrolling(A, B, C) | F targetFound")
    task = load_mission(surveillance).task
    assert str(task["search"]) == "G F at(A) & G F at(B) & G F at(C) | F targetFound"


@pytest.mark.parametrize(
    ("search", "wrong", "what"),
    [
        ("patrolling(A, D, C) | F targetFound", "D", "unknown fact at(D)"),
        ("delayed_reaction(targetfound, at(A))", "targetfound", "unknown fact targetfound"),
        ("G F at(A) & wait(A, at(E))", "at(E)", "unknown fact at(E)"),
        ("F at(A) & patrolling(B)", "patrolling", "patrolling cannot have 1 argument"),
    ],
)
def test_a_mission_error_is_located(surveillance: Path, search: str, wrong: str, what: str) -> None:
    rewrite(surveillance, search)
    lines = surveillance.read_text(encoding="utf-8").splitlines()
    number, line = next((n, x) for n, x in enumerate(lines, start=1) if search in x)
    column = line.index(wrong, line.index(search)) + 1
    with pytest.raises(MissionError) as caught:
        load_mission(surveillance)
    assert str(caught.value).startswith(f"{surveillance}:{number}:{column}: {what}\n")
    shown, caret = str(caught.value).splitlines()[1:3]
    start = caret.index("^")
    assert shown[start : start + caret.count("^")] == wrong


@pytest.mark.parametrize("text", ["wait(to, targetFound)", "global_avoidance(to)"])
def test_a_skill_refuses_patterns(surveillance: Path, text: str) -> None:
    content = surveillance.read_text(encoding="utf-8")
    assert "precondition: at(from)\n" in content
    spoilt = content.replace("precondition: at(from)\n", f"precondition: {text}\n")
    surveillance.write_text(spoilt, encoding="utf-8")
    with pytest.raises(MissionError) as caught:
        load_mission(surveillance)
    assert str(caught.value).startswith(f"{surveillance}:")
