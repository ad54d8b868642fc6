"""Languages that have a weak deterministic automaton get it, and it is minimal."""

from __future__ import annotations

import random

import pytest
from oracle import Sample, accepted, random_words, satisfying

from companion.ltl.automaton import BuchiAutomaton, statistics
from companion.ltl.components import strong_components
from companion.ltl.formula import Formula, negate
from companion.ltl.parser import parse
from companion.ltl.translate import translate


def is_weak(automaton: BuchiAutomaton) -> bool:
    """Whether in each component all edges have all marks, or none of them has some mark."""
    graph = [[t.target for t in leaving] for leaving in automaton.outgoing]
    for component in strong_components(graph):
        inside = [
            t.marks for s in component for t in automaton.outgoing[s] if t.target in component
        ]
        met = frozenset().union(*inside)
        if len(met) == automaton.marks and any(len(marks) < automaton.marks for marks in inside):
            return False
    return True


@pytest.mark.parametrize(
    ("text", "states"),
    [
        ("F p -> (!q U p)", 3),  # dac-02; the tableau needs 4
        ("G(p -> (F q -> (!q U r)))", 2),  # a bad prefix tells all: p, then q before r
        ("F p <-> !F q", 3),
        ("(F a & F b | F c) & G(c -> G !d)", 5),
        ("X p U X q | !X(p U q)", 1),  # valid
        ("G(a & X b) & F !b & X X F !b", 1),  # cannot hold
        ("X X X X a", 6),
    ],
)
def test_an_obligation_is_weak_and_deterministic(text: str, states: int) -> None:
    automaton = translate(parse(text))
    assert automaton.states == states
    assert statistics(automaton).is_deterministic
    assert is_weak(automaton)


@pytest.mark.parametrize("text", ["G F p", "F G p", "G F p -> G F q", "G(p -> F q)", "F G p | G q"])
def test_what_is_no_obligation_is_left_as_it_is(text: str) -> None:
    formula = parse(text)
    sample = Sample(random_words(("p", "q"), random.Random(5), 600))
    for each in (formula, negate(formula)):
        assert accepted(translate(each), sample) == satisfying(each, sample)


def test_a_powerset_that_explodes_is_given_up() -> None:
    """F(a & X^9 b) has 11 states; deterministically the last ten values of a are a state."""
    inner = parse("b")
    for _ in range(9):
        inner = parse(f"X ({inner})")
    formula: Formula = parse(f"F(a & {inner})")
    assert translate(formula).states <= 12
