"""A restricted automaton accepts what the whole one does, where the constants are constant."""

from __future__ import annotations

import itertools
from dataclasses import replace

import pytest
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st

from companion.ltl.automaton import BuchiAutomaton, successors
from companion.ltl.parser import parse
from companion.ltl.restriction import Restriction, restricted
from companion.ltl.semantics import Letter, accepts, holds
from companion.ltl.translate import translate

NAMES = ("a", "b", "c")
FORMULAS = [
    "G (F a | b)",
    "G (F a | b) & G (F c | b)",
    "G ((b | c) -> F c) & G (c -> X a)",
    "a U (b U c)",
    "F (a & X (b & X c))",
    "G F a & F G !b",
    "F G (a | b) | G F c",
    "(a W b) & (b R c)",
    "G (a -> X (!a W b)) & G F a & G F b",
    "G (a <-> X b)",
    "F a & (b | G !c)",
    "G F (a & F b) -> F G c",
]
LETTERS = [frozenset(some) for n in range(4) for some in itertools.combinations(NAMES, n)]
VALUES = st.dictionaries(st.sampled_from(NAMES), st.booleans())


def fixed(letter: Letter, constants: dict[str, bool]) -> Letter:
    """The letter with the constants as they are."""
    return frozenset(n for n in NAMES if constants.get(n, n in letter))


def accepts_from(automaton: BuchiAutomaton, states: list[int], loop: list[Letter]) -> bool:
    return accepts(replace(automaton, initial=frozenset(states)), loop[:-1], loop)


@pytest.mark.long
@pytest.mark.slow
@drawn(200)
@given(
    st.sampled_from(FORMULAS),
    VALUES,
    st.lists(st.sampled_from(LETTERS), max_size=3),
    st.lists(st.sampled_from(LETTERS), min_size=1, max_size=3),
)
def test_it_accepts_the_words_of_the_formula_in_which_the_constants_are_constant(
    formula: str, constants: dict[str, bool], prefix: list[Letter], loop: list[Letter]
) -> None:
    whole = translate(parse(formula))
    part = restricted(whole, constants)
    prefix = [fixed(letter, constants) for letter in prefix]
    loop = [fixed(letter, constants) for letter in loop]
    initial = frozenset(part.states(whole.initial))
    verdict = accepts(replace(part.automaton, initial=initial), prefix, loop)
    assert verdict is holds(parse(formula), prefix, loop)


@pytest.mark.slow
@drawn(100)
@given(st.sampled_from(FORMULAS), VALUES, st.data())
def test_any_set_of_states_accepts_as_much_as_before(
    formula: str, constants: dict[str, bool], data: st.DataObject
) -> None:
    """Whatever a history has led to; before it the constants may have had other values."""
    whole = translate(parse(formula))
    part = restricted(whole, constants)
    states = frozenset(data.draw(st.sets(st.integers(0, whole.states - 1))))
    kept = part.states(states)
    assert len(kept) <= len(states)
    for _ in range(5):
        drawn = data.draw(st.lists(st.sampled_from(LETTERS), min_size=1, max_size=3))
        loop = [fixed(letter, constants) for letter in drawn]
        assert accepts_from(part.automaton, kept, loop) is accepts_from(whole, [*states], loop)


@pytest.mark.parametrize("formula", FORMULAS)
@pytest.mark.parametrize("constants", [{}, {"b": True}, {"b": False}, {"a": False, "c": True}])
def test_it_is_no_larger_and_reads_what_is_left(formula: str, constants: dict[str, bool]) -> None:
    whole = translate(parse(formula))
    part = restricted(whole, constants)
    assert part.automaton.states <= whole.states
    assert set(part.automaton.propositions) <= set(whole.propositions) - set(constants)
    assert set(part.state_of) <= set(range(whole.states))
    assert set(part.state_of.values()) == set(range(part.automaton.states))


def initial_states(formula: str, constants: dict[str, bool]) -> tuple[Restriction, list[int]]:
    whole = translate(parse(formula))
    part = restricted(whole, constants)
    return part, part.states(whole.initial)


def test_the_search_for_a_target_is_a_patrol_until_it_is_found_and_nothing_afterwards() -> None:
    """The example of the module."""
    part, _ = initial_states("G (F a | b)", {"b": False})
    patrol = translate(parse("G F a"))
    assert (part.automaton.states, part.automaton.marks) == (patrol.states, patrol.marks)
    assert part.automaton.propositions == ("a",)
    part, states = initial_states("G (F a | b)", {"b": True})
    assert set(states) <= part.everything


def test_a_state_that_accepts_nothing_any_more_has_no_place() -> None:
    part, states = initial_states("G !b & F a", {"b": True})
    assert states == []
    assert part.state_of == {}


def test_a_state_that_accepts_everything_is_known() -> None:
    whole = translate(parse("F a"))
    seen = successors(whole, whole.initial, frozenset({"a"}))
    part = restricted(whole, {})
    assert part.everything.intersection(part.states(seen))
    assert not part.everything.intersection(part.states(whole.initial))


@pytest.mark.parametrize(
    ("formula", "constants", "is_one_shot"),
    [
        ("F a", {}, True),
        ("F (a | b)", {"b": False}, True),
        ("F (a & b)", {"b": True}, True),
        ("b -> F a", {"b": True}, True),
        ("F (a & b)", {}, True),
        ("G F a", {}, False),
        ("F G a", {}, False),
        ("c U a", {}, False),
        ("c U a", {"c": True}, True),
        ("c W a", {"c": True}, False),
        ("F (a & F b)", {}, False),
        ("G a", {}, False),
        ("F a", {"a": False}, False),
    ],
)
def test_what_waits_for_one_letter_is_a_one_shot_goal(
    formula: str, constants: dict[str, bool], is_one_shot: bool
) -> None:
    part, states = initial_states(formula, constants)
    assert (bool(states) and set(states) <= part.one_shot_goals) is is_one_shot
    assert not part.one_shot_goals & part.everything
