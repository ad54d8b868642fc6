"""Marks on states: the same language, also on words drawn at random, and in HOA's own place."""

from __future__ import annotations

import csv
from functools import cache
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from companion.ltl.automaton import BuchiAutomaton, Label, Transition, state_based
from companion.ltl.hoa import to_hoa
from companion.ltl.parser import parse
from companion.ltl.semantics import Letter, accepts, holds
from companion.ltl.translate import translate

TABLE = Path(__file__).parents[2] / "data" / "formulas.tsv"


def _sample() -> list[str]:
    """The formulas of the group eh, and every fourth of the group dac."""
    with TABLE.open(encoding="utf-8", newline="") as stream:
        rows = [row for row in csv.reader(stream, delimiter="\t") if not row[0].startswith("#")]
    patterns = [row for row in rows if row[0] == "dac"]
    chosen = [row for row in rows if row[0] == "eh"] + patterns[::4]
    return [row[2] for row in chosen]


SAMPLE = _sample()
LETTERS = st.frozensets(st.sampled_from([f"p{i}" for i in range(7)]))
WORDS = st.tuples(st.lists(LETTERS, max_size=4), st.lists(LETTERS, min_size=1, max_size=4))
ANY = Label(frozenset(), frozenset())


def test_the_sample_is_there() -> None:
    assert len(SAMPLE) == 12 + 14


@cache
def _state_based(text: str) -> BuchiAutomaton:
    return state_based(translate(parse(text)))


@pytest.mark.parametrize("text", SAMPLE)
@settings(max_examples=30, deadline=None)
@given(words=st.lists(WORDS, min_size=4, max_size=4))
def test_the_language_stays(text: str, words: list[tuple[list[Letter], list[Letter]]]) -> None:
    formula = parse(text)
    automaton = _state_based(text)
    for prefix, loop in words:
        assert accepts(automaton, prefix, loop) is holds(formula, prefix, loop)


@pytest.mark.parametrize("text", SAMPLE)
def test_a_state_accepts_or_not(text: str) -> None:
    automaton = _state_based(text)
    assert automaton.marks == 1
    assert automaton.has_state_acceptance
    assert state_based(automaton).states == automaton.states


def test_a_state_with_different_marks_has_no_state_acceptance() -> None:
    mixed = translate(parse("G F a"))
    assert not mixed.has_state_acceptance
    assert state_based(mixed).states == 2


def test_several_initial_states_stay_initial() -> None:
    loops = [Transition(s, ANY, s, frozenset({0} if i else ())) for s in (0, 1) for i in (0, 1)]
    automaton = state_based(BuchiAutomaton(2, frozenset({0, 1}), tuple(loops), 1))
    assert automaton.initial == {0, 1}
    assert automaton.states == 4


def test_hoa_writes_the_marks_after_the_states() -> None:
    text = to_hoa(state_based(translate(parse("G F a"))), marks_on_states=True)
    assert "properties: trans-labels explicit-labels state-acc\n" in text
    assert text.endswith("""\
--BODY--
State: 0
[0] 1
[!0] 0
State: 1 {0}
[0] 1
[!0] 0
--END--
""")


def test_hoa_refuses_to_put_different_marks_on_a_state() -> None:
    with pytest.raises(ValueError, match="different marks"):
        to_hoa(translate(parse("G F a")), marks_on_states=True)


def test_a_state_without_transitions_has_no_mark() -> None:
    text = to_hoa(translate(parse("false")), marks_on_states=True)
    assert "State: 0\n--END--" in text
