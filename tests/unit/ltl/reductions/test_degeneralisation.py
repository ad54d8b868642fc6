"""Marks on states: the same language, also on words drawn at random, and in HOA's own place."""

from __future__ import annotations

import pytest

from companion.ltl.automaton import BuchiAutomaton, Label, Transition
from companion.ltl.hoa import to_hoa
from companion.ltl.parser import parse
from companion.ltl.translate import state_based, translate

ANY = Label(frozenset(), frozenset())


def test_a_state_with_different_marks_has_no_state_acceptance() -> None:
    mixed = translate(parse("G F a"))
    assert not mixed.has_state_acceptance
    assert state_based(mixed).states == 2


def test_several_initial_states_become_one() -> None:
    loops = [Transition(s, ANY, s, frozenset({0} if i else ())) for s in (0, 1) for i in (0, 1)]
    automaton = state_based(BuchiAutomaton(2, frozenset({0, 1}), tuple(loops), 1))
    assert automaton.initial == {0}


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
