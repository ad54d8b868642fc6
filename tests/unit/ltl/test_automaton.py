"""Labels, the subset construction, figures, and automata as networkx graphs."""

from __future__ import annotations

import subprocess
import sys
from itertools import chain, combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.ltl.automaton import (
    BuchiAutomaton,
    Label,
    Statistics,
    Transition,
    statistics,
    successors,
)
from companion.ltl.parser import parse
from companion.ltl.translate import translate

A_NOT_B = Label(frozenset({"a"}), frozenset({"b"}))
ANY = Label(frozenset(), frozenset())


def test_a_label_matches_every_letter_that_agrees_with_its_literals() -> None:
    assert A_NOT_B.matches(frozenset({"a", "c"}))
    assert not A_NOT_B.matches(frozenset({"a", "b"}))
    assert not A_NOT_B.matches(frozenset())
    assert ANY.matches(frozenset())
    assert (str(A_NOT_B), str(ANY)) == ("a & !b", "true")


def test_successors_follow_every_run() -> None:
    automaton = BuchiAutomaton(
        3,
        frozenset({0}),
        (
            Transition(0, ANY, 0, frozenset()),
            Transition(0, A_NOT_B, 1, frozenset({0})),
            Transition(1, ANY, 2, frozenset()),
        ),
        1,
    )
    assert automaton.propositions == ("a", "b")
    assert [len(leaving) for leaving in automaton.outgoing] == [2, 1, 0]
    assert successors(automaton, frozenset({0}), frozenset({"a"})) == {0, 1}
    assert successors(automaton, frozenset({0, 1}), frozenset()) == {0, 2}
    assert successors(automaton, frozenset({2}), frozenset()) == frozenset()


@pytest.mark.parametrize(
    ("text", "figures"),
    [
        ("G F a", Statistics(1, 2, 1, 1, True, True)),
        ("G a", Statistics(1, 1, 0, 1, True, False)),
        ("true", Statistics(1, 1, 0, 0, True, True)),
        ("false", Statistics(1, 0, 0, 0, True, False)),
        ("F G a", Statistics(2, 3, 1, 1, False, False)),
        ("G F a & G F b", Statistics(1, 4, 2, 2, True, True)),
    ],
)
def test_figures_of_a_formula(text: str, figures: Statistics) -> None:
    assert statistics(translate(parse(text))) == figures


def test_two_initial_states_are_a_choice_and_none_leaves_no_run() -> None:
    loops = (Transition(0, ANY, 0, frozenset()), Transition(1, ANY, 1, frozenset()))
    two = statistics(BuchiAutomaton(2, frozenset({0, 1}), loops, 0))
    none = statistics(BuchiAutomaton(2, frozenset(), loops, 0))
    assert (two.is_deterministic, two.is_complete) == (False, True)
    assert (none.is_deterministic, none.is_complete) == (True, False)


NAMES = ("a", "b", "c")
EVERY_LETTER = [
    frozenset(letter)
    for letter in chain.from_iterable(combinations(NAMES, size) for size in range(4))
]
LABELS = st.builds(
    lambda signs: Label(
        frozenset(name for name, sign in zip(NAMES, signs, strict=True) if sign == 1),
        frozenset(name for name, sign in zip(NAMES, signs, strict=True) if sign == -1),
    ),
    st.tuples(*[st.sampled_from([-1, 0, 1])] * 3),
)


@given(st.lists(LABELS, max_size=6))
def test_determinism_and_completeness_are_about_letters(labels: list[Label]) -> None:
    loops = tuple(Transition(0, label, 0, frozenset()) for label in labels)
    figures = statistics(BuchiAutomaton(1, frozenset({0}), loops, 0))
    readers = [sum(label.matches(letter) for label in labels) for letter in EVERY_LETTER]
    assert figures.is_deterministic is (max(readers) <= 1)
    assert figures.is_complete is (min(readers) >= 1)


def test_a_networkx_graph_has_all_states_and_transitions() -> None:
    automaton = translate(parse("(a U b) & G F c | X !a"))
    graph = automaton.to_networkx()
    assert graph.graph == {"name": automaton.name, "marks": automaton.marks}
    assert {s for s, is_initial in graph.nodes(data="initial") if is_initial} == automaton.initial
    assert sorted(graph.nodes) == list(range(automaton.states))
    assert sorted((*ends, *data.values()) for *ends, data in graph.edges(data=True)) == sorted(
        (t.source, t.target, str(t.label), tuple(sorted(t.marks))) for t in automaton.transitions
    )


def test_networkx_is_loaded_when_it_is_asked_for() -> None:
    script = "import sys, companion.ltl.translate; print(*sys.modules)"
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "networkx" not in done.stdout.split()
