"""The automata as they are drawn stand where the runs of the automata are, at every position."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from companion.ltl.monitor import Runs
from companion.ltl.parser import parse
from companion.ltl.semantics import holds
from companion.ltl.translate import translate
from companion.monitor.automata import DrawnAutomaton, TaskReader

FORMULAS = (
    "G (F p | q)",
    "G (p -> X q)",
    "F (p & F q)",
    "(!p U q) & G F p",
    "F G p | G F q",
    "G F p & G F q",
)
letters = st.frozensets(st.sampled_from(["p", "q"]))


def drawing(text: str) -> DrawnAutomaton:
    formula = parse(text)
    return DrawnAutomaton("it", str(formula), translate(formula))


@given(st.sampled_from(FORMULAS), st.lists(letters, max_size=8))
def test_the_nodes_are_those_of_the_runs(text: str, word: list[frozenset[str]]) -> None:
    drawn = drawing(text)
    nodes, runs = drawn.start, Runs.begin(drawn.automaton)
    assert {state for state, _ in nodes} == runs.states
    for letter in word:
        nodes, runs = drawn.after(nodes, letter), runs.after(letter)
        assert {state for state, _ in nodes} == runs.states
        assert nodes <= set(drawn.nodes)


@given(st.lists(letters, max_size=4), st.lists(letters, min_size=1, max_size=3))
def test_rings_say_which_words_are_accepted(
    prefix: list[frozenset[str]], loop: list[frozenset[str]]
) -> None:
    """Where runs are deterministic a word is accepted if the loop meets a ring, lap after lap."""
    drawn = drawing("G (F p | q)")
    nodes = drawn.start
    rung = False
    for lap in range(12):
        for letter in prefix if lap == 0 else loop:
            nodes = drawn.after(nodes, letter)
            ((_, marks),) = nodes
            rung |= lap == 11 and len(marks) == drawn.automaton.marks
    assert rung == holds(parse(drawn.text), prefix, loop)


def test_a_violated_conjunct_stands_nowhere_and_may_begin_anew() -> None:
    reader = TaskReader({"calm": parse("G !p"), "later": parse("F q")})
    begin = reader.moved.states
    assert all(begin)
    reader.read(frozenset({"p"}), ())
    assert reader.moved.states[0] == () and reader.moved.states[1]
    reader.read(frozenset(), ("calm",))
    assert reader.moved.states[0]


def test_the_edge_just_taken_leads_from_where_it_was() -> None:
    reader = TaskReader({"it": parse("G (p -> F q)")})
    for letter in (frozenset({"p"}), frozenset[str](), frozenset({"q"})):
        before = reader.moved.states[0]
        reader.read(letter, ())
        after = reader.moved
        assert {start for start, _ in after.taken[0]} <= set(before)
        assert {end for _, end in after.taken[0]} == set(after.states[0])
        drawn = {(arrow.start, arrow.end) for arrow in reader.automata[0].drawing.arrows}
        assert set(after.taken[0]) <= drawn


def test_a_line_of_the_task_is_drawn_by_its_conjuncts() -> None:
    reader = TaskReader({"both": parse("G (F p & F q)")})
    drawings = [automaton.drawing for automaton in reader.automata]
    assert [drawn.formula for drawn in drawings] == ["G F p", "G F q"]
    for drawn in drawings:
        count = len(drawn.accepting)
        assert any(drawn.accepting)
        assert all(0 <= a < count and 0 <= b < count and label for a, b, label in drawn.arrows)


def test_a_patrol_of_many_places_is_small_enough_for_a_page() -> None:
    """The vehicle is at one place at a time."""
    places = [f"at(P{number})" for number in range(10)]
    reader = TaskReader(
        {"patrol": parse(" & ".join(["F b"] + [f"G F {p}" for p in places]) + " | F c")}
    )
    assert sum(len(each.drawing.arrows) for each in reader.automata) < 1000
    reader.read(frozenset({"b", places[3]}), ())
    assert all(reader.moved.states)
