"""Automata of published formulas: they accept what the semantics says, and they are small."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.ltl.budget import TranslationLimit
from companion.ltl.parser import parse
from companion.ltl.translate import translate

FORMULAS = Path(__file__).parents[2] / "data" / "formulas.tsv"
WORDS = 24
"""Lasso words a formula, before mutations."""


@pytest.mark.parametrize(
    ("text", "states", "marks"),
    [
        ("G(F at(A) | targetFound)", 2, 1),
        ("G((targetFound | targetReported) -> F targetReported)", 2, 1),
        ("G(targetReported -> X at(Home))", 2, 0),
        ("G F p", 1, 1),
        ("G F p & G F q", 1, 2),
        ("F p", 2, 1),
        ("p U q", 2, 1),
        ("F G p", 2, 1),
        ("X p", 3, 0),
        ("true", 1, 0),
        ("G F(a <-> X a)", 2, 1),  # it starts again where F(a <-> X a) is over
        ("G F(a & X b)", 2, 1),
        ("F(a & F c) & G F a & G F c", 1, 2),
        ("G F(a & X X X b)", 4, 1),  # it guesses where a & X X X b begins
        ("F c & G F(a & X X X b)", 5, 1),  # which does not matter before c
        ("G a | G F b", 2, 1),  # it waits for b, or for nothing, in one state
        ("a U (b | X F(c & G d))", 4, 1),
        ("G F a U (a | b)", 3, 1),  # edges between components keep their marks
        ("G(c -> X(!c W e)) & F e & G F c", 2, 1),  # F e follows from the others
        ("p1 R (p2 U !p3 W p0) & X(!p1 | p1 & X p1)", 13, 1),
    ],
)
def test_size(text: str, states: int, marks: int) -> None:
    automaton = translate(parse(text))
    assert (automaton.states, automaton.marks) == (states, marks)
    assert automaton.initial == {0}


@pytest.mark.parametrize("text", ["false", "F a & G !a", "X(a & !a)", "G F a & F G !a"])
def test_what_cannot_hold_has_no_transition(text: str) -> None:
    automaton = translate(parse(text))
    assert (automaton.states, automaton.transitions) == (1, ())


@pytest.mark.parametrize(
    "text",
    [
        "G(F at(A) | targetFound)",
        "G((targetFound | targetReported) -> F targetReported)",
        "G(targetReported -> X at(Home))",
    ],
)
def test_conjuncts_of_the_paper_are_deterministic(text: str) -> None:
    automaton = translate(parse(text))
    names = automaton.propositions
    for bits in range(1 << len(names)):
        letter = frozenset(name for i, name in enumerate(names) if bits >> i & 1)
        for leaving in automaton.outgoing:
            assert sum(transition.label.matches(letter) for transition in leaving) <= 1


def test_limit() -> None:
    memory = parse("G(a -> " + "X " * 8 + "b)")  # the last eight values of a
    with pytest.raises(TranslationLimit, match="more than 100 states"):
        translate(memory, max_states=100)
    choices = parse(" & ".join(f"(a{i} | b{i})" for i in range(12)))
    with pytest.raises(TranslationLimit, match="more than 1,000 transitions"):
        translate(choices, max_states=1000)
