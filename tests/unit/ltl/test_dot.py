"""DOT text: the whole automaton can be read back from the drawing."""

from __future__ import annotations

import re

import pytest

from companion.ltl.automaton import BuchiAutomaton, Label, Transition
from companion.ltl.dot import to_dot
from companion.ltl.parser import parse
from companion.ltl.translate import state_based, translate

QUOTED = r'"((?:[^"\\]|\\.)*)"'
"""A string as Graphviz reads it: a quote inside is escaped."""

STATEMENT = re.compile(
    rf"  (?:rankdir=LR|node \[shape=circle\]|start(?P<start>\d+) \[shape=point\]"
    rf"|start(?P<from>\d+) -> (?P<to>\d+)|(?P<state>\d+)(?P<double> \[shape=doublecircle\])?"
    rf"|(?P<source>\d+) -> (?P<target>\d+) \[label={QUOTED}\])"
)


def read(text: str) -> tuple[set[int], set[int], set[int], list[tuple[int, str, str, int]]]:
    """States, initial states, states with a double line, edges (source, label, marks, target)."""
    head, *body, end, nothing = text.split("\n")
    assert re.fullmatch(rf"digraph {QUOTED} \{{", head)
    assert (end, nothing) == ("}", "")
    states, initial, double = set(), set(), set()
    edges = []
    for line in body:
        found = STATEMENT.fullmatch(line)
        assert found, line
        if found["state"]:
            states.add(int(found["state"]))
            if found["double"]:
                double.add(int(found["state"]))
        elif found["from"]:
            assert found["from"] == found["to"]
            initial.add(int(found["to"]))
        elif found["source"]:
            label, _, marks = found[found.lastindex or 0].partition("\\n")
            edges.append((int(found["source"]), label, marks, int(found["target"])))
    return states, initial, double, edges


@pytest.mark.parametrize(
    "text",
    ["G(F at(A) | targetFound)", "G F a & G F b", "a U b | F G c", "false", "true", "X a"],
)
def test_the_drawing_shows_the_automaton(text: str) -> None:
    automaton = translate(parse(text))
    states, initial, double, edges = read(to_dot(automaton))
    assert states == set(range(automaton.states))
    assert initial == automaton.initial
    on_states = automaton.marks == 1 and automaton.has_state_acceptance
    assert edges == [
        (
            t.source,
            str(t.label),
            "" if on_states or not t.marks else f"{{{', '.join(map(str, sorted(t.marks)))}}}",
            t.target,
        )
        for leaving in automaton.outgoing
        for t in leaving
    ]
    assert double == {t.source for t in automaton.transitions if on_states and t.marks}


def test_marks_of_several_sets_stand_on_edges() -> None:
    edges = read(to_dot(translate(parse("G F a & G F b"))))[3]
    assert {(label, marks) for _, label, marks, _ in edges} >= {("a & b", "{0, 1}")}


def test_accepting_states_have_a_double_line_and_edges_no_marks() -> None:
    automaton = state_based(translate(parse("G F a")))
    _, _, double, edges = read(to_dot(automaton))
    assert double == {t.source for t in automaton.transitions if t.marks}
    assert 0 < len(double) < automaton.states
    assert all(marks == "" for _, _, marks, _ in edges)


def test_quotes_in_names_are_escaped() -> None:
    label = Label(frozenset({'say "a"'}), frozenset())
    automaton = BuchiAutomaton(1, frozenset({0}), (Transition(0, label, 0, frozenset()),), 0, '"b"')
    assert r'[label="say \"a\""]' in to_dot(automaton)
    assert read(to_dot(automaton))[3] == [(0, r"say \"a\"", "", 0)]
