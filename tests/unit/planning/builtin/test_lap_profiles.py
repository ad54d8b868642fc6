"""What a lap does to an automaton: held against runs, one after the other."""

from __future__ import annotations

import itertools
from dataclasses import replace

import pytest
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st

from companion.ltl.automaton import BuchiAutomaton
from companion.ltl.parser import parse
from companion.ltl.restriction import restricted
from companion.ltl.semantics import accepts
from companion.ltl.translate import translate
from companion.planning.builtin.fact_bits import FactBits
from companion.planning.builtin.lap_profiles import EMPTY, LapProfiles
from companion.planning.builtin.masked_automaton import MaskedAutomaton

FORMULAS = [
    "G F p",
    "F (p & X q)",
    "G F (p & X q)",
    "G F (p & X X p)",
    "G (p -> F q)",
    "G F p -> G F q",
    "F G p | G F q",
    "p U (q U !p)",
]
NAMES = ("p", "q")
LETTERS = [frozenset(some) for n in range(3) for some in itertools.combinations(NAMES, n)]
BITS = FactBits()
FACTS = {letter: BITS.mask(letter) for letter in LETTERS}


def automaton(formula: str) -> BuchiAutomaton:
    return restricted(translate(parse(formula)), {}).automaton


def profiles(formula: str) -> LapProfiles:
    return LapProfiles(MaskedAutomaton(automaton(formula), 0, BITS))


@pytest.mark.slow
@drawn(100)
@given(st.sampled_from(FORMULAS), st.lists(st.sampled_from(LETTERS), min_size=1, max_size=5))
def test_a_lap_is_accepted_from_the_states_that_accept_it_for_ever(
    formula: str, lap: list[frozenset[str]]
) -> None:
    whole, made = automaton(formula), profiles(formula)
    profile = EMPTY
    for letter in lap:
        profile = made.after(profile, FACTS[letter])
    assert profile != EMPTY
    expected = {
        state
        for state in range(whole.states)
        if accepts(replace(whole, initial=frozenset({state})), [], lap)
    }
    assert made.accepting(profile) == expected


@pytest.mark.parametrize("formula", ["G F p", "G (p -> F q)", "F (p & X q)"])
def test_a_cycle_of_these_takes_one_lap(formula: str) -> None:
    assert profiles(formula).max_laps(FACTS.values()) == 1


def test_a_cycle_may_take_several_laps() -> None:
    """Of p for ever, every second position counts: the automaton looks two ahead, then anew."""
    swapping = BuchiAutomaton(2, frozenset({0}), (), 1)
    swapping = replace(
        swapping,
        transitions=tuple(
            replace(t, source=a, target=1 - a, marks=frozenset(range(a)))
            for a in (0, 1)
            for t in automaton("true").transitions[:1]
        ),
    )
    made = LapProfiles(MaskedAutomaton(swapping, 0, BITS))
    assert made.max_laps([0]) == 2
    assert made.accepting(made.after(EMPTY, 0)) == {0, 1}
