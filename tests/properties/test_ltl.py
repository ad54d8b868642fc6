"""Laws of LTL, and every transformation of a formula, held against the direct semantics."""

from __future__ import annotations

import random

import pytest
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st
from oracle import Sample, accepted, random_words, satisfying, small_words

from companion.ltl.automaton import successors
from companion.ltl.conjuncts import conjuncts
from companion.ltl.formula import (
    FALSE,
    TRUE,
    Formula,
    Operator,
    atoms,
    conjoin,
    negate,
    negation_normal_form,
)
from companion.ltl.literals import literals
from companion.ltl.parser import parse
from companion.ltl.semantics import Letter, holds
from companion.ltl.simplify import simplified
from companion.ltl.translate import state_based, translate

NAMES = ("a", "at(B)", "ok(B, C)")
Word = tuple[list[Letter], list[Letter]]

UNARY = [Operator.NOT, Operator.NEXT, Operator.EVENTUALLY, Operator.ALWAYS]
BINARY = [
    Operator.UNTIL,
    Operator.RELEASE,
    Operator.WEAK_UNTIL,
    Operator.IMPLIES,
    Operator.IFF,
]


def _larger(inner: st.SearchStrategy[Formula]) -> st.SearchStrategy[Formula]:
    pairs = st.tuples(inner, inner)
    return (
        st.builds(lambda op, f: Formula(op, (f,)), st.sampled_from(UNARY), inner)
        | st.builds(Formula, st.sampled_from(BINARY), pairs)
        | st.builds(
            lambda op, fs: Formula(op, tuple(fs)),
            st.sampled_from([Operator.AND, Operator.OR]),
            st.lists(inner, min_size=2, max_size=3),
        )
    )


FORMULAS = st.recursive(
    st.sampled_from([*(parse(name) for name in NAMES * 3), TRUE, FALSE]), _larger, max_leaves=6
)
LETTERS = st.frozensets(st.sampled_from(NAMES))
WORDS = st.tuples(st.lists(LETTERS, max_size=3), st.lists(LETTERS, min_size=1, max_size=3))
SEVERAL = st.lists(WORDS, min_size=8, max_size=8)


@given(FORMULAS)
def test_printing_and_parsing_are_inverse(formula: Formula) -> None:
    assert parse(str(formula)) is formula


@given(FORMULAS, SEVERAL)
def test_every_form_has_the_same_meaning(formula: Formula, words: list[Word]) -> None:
    normal = negation_normal_form(formula)
    short = simplified(normal)
    split = conjoin(*conjuncts(formula))
    assert simplified(short) is short
    assert atoms(short) <= atoms(formula)
    for prefix, loop in words:
        verdict = holds(formula, prefix, loop)
        assert holds(normal, prefix, loop) is verdict
        assert holds(short, prefix, loop) is verdict
        assert holds(split, prefix, loop) is verdict
        assert holds(negate(formula), prefix, loop) is not verdict


SAMPLE = Sample(small_words(NAMES, 700) + random_words(NAMES, random.Random(1), 1500))


@drawn(300)
@given(FORMULAS)
def test_an_automaton_accepts_what_satisfies_the_formula(formula: Formula) -> None:
    satisfied = satisfying(formula, SAMPLE)
    automaton, opposite = translate(formula), translate(negate(formula))
    split = state_based(automaton)
    assert split.has_state_acceptance
    for form in (automaton, split):
        assert accepted(form, SAMPLE) == satisfied
    assert accepted(opposite, SAMPLE) == SAMPLE.everyone ^ satisfied


@given(FORMULAS, SEVERAL)
def test_two_ways_to_the_semantics_agree(formula: Formula, words: list[Word]) -> None:
    """The definition as flown, and the oracle of the tests."""
    sample = Sample((tuple(prefix), tuple(loop)) for prefix, loop in words)
    satisfied = satisfying(formula, sample)
    for i, (prefix, loop) in enumerate(sample.words):
        assert bool(satisfied >> i & 1) is holds(formula, prefix, loop)


@given(FORMULAS, WORDS, st.lists(LETTERS, min_size=6, max_size=6))
def test_more_of_what_is_only_wanted_and_less_of_what_is_only_unwanted_does_no_harm(
    formula: Formula, word: Word, changes: list[Letter]
) -> None:
    prefix, loop = word
    positive, negative = literals(formula)
    changed = [
        (letter - (change & (negative - positive))) | (change & (positive - negative))
        for letter, change in zip([*prefix, *loop], changes, strict=False)
    ]
    if holds(formula, prefix, loop):
        assert holds(formula, changed[: len(prefix)], changed[len(prefix) :])
    assert positive | negative <= atoms(formula)


@given(FORMULAS, WORDS)
def test_the_subset_construction_never_loses_a_word(formula: Formula, word: Word) -> None:
    """From the states reached by a prefix the rest of an accepted word is accepted."""
    automaton = translate(formula)
    prefix, loop = word
    states = automaton.initial
    for letter in prefix:
        states = successors(automaton, states, letter)
    if holds(formula, prefix, loop):
        assert states


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ("!X a", "X !a"),
        ("!(a U at(B))", "!a R !at(B)"),
        ("F a", "true U a"),
        ("G a", "!F !a"),
        ("a W at(B)", "a U at(B) | G a"),
        ("a U at(B)", "at(B) | a & X(a U at(B))"),
        ("a R at(B)", "at(B) & (a | X(a R at(B)))"),
        ("F(a | at(B))", "F a | F at(B)"),
        ("G(a & at(B))", "G a & G at(B)"),
        ("G F(a | at(B))", "G F a | G F at(B)"),
        ("a U (a U at(B))", "a U at(B)"),
        ("X(a U at(B))", "X a U X at(B)"),
        ("a <-> at(B)", "(a -> at(B)) & (at(B) -> a)"),
        ("a R at(B)", "at(B) W (a & at(B))"),
    ],
)
def test_textbook_law(left: str, right: str) -> None:
    """Baier and Katoen, Section 5.1.4: both sides exclude the other's negation."""
    for one, other in ((left, right), (right, left)):
        automaton = translate(parse(f"({one}) & !({other})"))
        assert automaton.transitions == ()
