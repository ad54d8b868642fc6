"""The transition system over bits does what the actions do to sets, and knows what is constant."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st
from problems import action, move
from synthetic import facts_of

from companion.errors import SearchLimit
from companion.mission.facts import Fact
from companion.planning.builtin.fact_bits import FactBits
from companion.planning.builtin.masked_actions import KnownActions
from companion.planning.builtin.transition_system import TransitionSystem
from companion.planning.domain import WAIT, Action, ConditionalEffect

FACTS = tuple(map(Fact, "pqrst"))
SOME = st.frozensets(st.sampled_from(FACTS), max_size=2)
EFFECTS = st.builds(ConditionalEffect, SOME, SOME, SOME, SOME)


@st.composite
def actions(draw: st.DrawFn) -> list[Action]:
    made = []
    for i in range(draw(st.integers(0, 5))):
        requires, forbids, adds, deletes = (draw(SOME) for _ in range(4))
        effects = tuple(draw(st.lists(EFFECTS, max_size=2)))
        cost_ms = draw(st.integers(1, 9)) * 100
        made.append(
            Action(
                f"a{i}",
                ("a",),
                requires,
                forbids,
                frozenset(),
                adds,
                deletes,
                cost_ms,
                WAIT.execute,
                1,
                None,
                effects,
            )
        )
    return made


def system(made: list[Action], facts: frozenset[Fact]) -> tuple[KnownActions, TransitionSystem]:
    known = KnownActions(made)
    return known, TransitionSystem(made, facts, known)


def reachable(made: list[Action], facts: frozenset[Fact]) -> set[frozenset[Fact]]:
    seen, todo = {facts}, [facts]
    while todo:
        here = todo.pop()
        after = {a.apply(here) for a in made if a.is_applicable(here)} - seen
        seen |= after
        todo += after
    return seen


@given(actions(), st.frozensets(st.sampled_from(FACTS)))
def test_successors_are_what_the_actions_do_in_every_reachable_state(
    made: list[Action], start: frozenset[Fact]
) -> None:
    known, found = system(made, start)
    assert found.start == known.state(start)
    for facts in reachable(made, start):
        expected = [
            (known.state(a.apply(facts)), i, a.cost_ms)
            for i, a in enumerate(made)
            if a.is_applicable(facts)
        ]
        assert list(found.steps(known.state(facts))) == expected


@given(actions(), st.frozensets(st.sampled_from(FACTS)))
def test_its_graph_has_every_reachable_state_and_every_action_there(
    made: list[Action], start: frozenset[Fact]
) -> None:
    _, found = system(made, start)
    graph = found.to_networkx()
    constant = graph.graph["constant"]
    facts = {node: held | constant for node, held in graph.nodes(data="facts")}
    assert facts[0] == start
    assert sorted(map(sorted, facts.values())) == sorted(map(sorted, reachable(made, start)))
    expected = {
        (before, action.apply(before), action.name, action.cost_ms)
        for before in facts.values()
        for action in made
        if action.is_applicable(before)
    }
    edges = [
        (facts[a], facts[b], data["action"], data["cost_ms"])
        for a, b, data in graph.edges(data=True)
    ]
    assert len(edges) == len(expected) and set(edges) == expected
    assert all(key == data["action"] for *_, key, data in graph.edges(keys=True, data=True))


def test_a_graph_of_too_many_states_is_refused() -> None:
    toggles = [action(f"set_{i}", "", f"x{i}") for i in range(10)]
    _, found = system(toggles, frozenset())
    assert len(found.to_networkx()) == 1024
    with pytest.raises(SearchLimit, match="1,000 states of the transition system"):
        found.to_networkx(max_states=1000)


@given(actions(), st.frozensets(st.sampled_from(FACTS)))
def test_what_is_said_never_to_change_never_does(
    made: list[Action], start: frozenset[Fact]
) -> None:
    known, found = system(made, start)
    changing = known.bits.facts(found.changing)
    assert not changing & found.constant
    for facts in reachable(made, start):
        assert facts - changing == found.constant


@given(st.lists(st.frozensets(st.sampled_from(FACTS)), min_size=2))
def test_different_facts_have_different_bits(several: list[frozenset[Fact]]) -> None:
    bits = FactBits()
    masks = [bits.mask(facts) for facts in several]
    assert [mask.bit_count() for mask in masks] == [len(facts) for facts in several]
    for (a, mask_a), (b, mask_b) in itertools.pairwise(zip(several, masks, strict=True)):
        assert bits.mask(a | b) == mask_a | mask_b
        assert bits.mask(a & b) == mask_a & mask_b


def test_events_and_beliefs_are_constant_and_places_are_not() -> None:
    made = [
        move("H", "A", 1.0),
        move("A", "H", 1.0),
        action("upload", "at(A) & found & can", "reported"),
        action("report", "at(A) & can", "reported"),
    ]
    known, found = system(made, facts_of("at(H)", "can"))
    assert known.bits.facts(found.changing) == {"at(H)", "at(A)", "reported"}
    assert found.constant == {"can"}
    values = [found.constant_value(name) for name in ("can", "found", "reported")]
    assert values == [True, False, None]


def test_an_action_that_forbids_what_always_holds_does_not_exist() -> None:
    """And so what it alone could delete is constant as well, in as many passes as that takes."""
    made = [
        action("end_day", "!day_is_long", "!sun"),
        action("set_lamp", "!sun", "lamp"),
        action("break_lamp", "", "", conditional=[("!sun", "broken"), ("broken", "!lamp")]),
    ]
    known, found = system(made, facts_of("sun", "day_is_long"))
    assert found.constant == {"sun", "day_is_long"}
    assert not known.bits.facts(found.changing) & {"sun", "lamp"}


def test_what_is_added_and_deleted_at_once_is_added() -> None:
    made = [action("both", "", "q", conditional=[("", "!q"), ("q", "!q")])]
    known, found = system(made, frozenset())
    q = known.state(facts_of("q"))
    assert found.successors(found.start).states == [q]
    assert found.successors(q).states == [q]


MADE = [
    move("H", "A", 1.0),
    action("upload", "at(A) & found & can", "reported"),
    action("look", "at(A)", "", conditional=[("sun", "seen"), ("!sun", "!seen")]),
]


@pytest.mark.parametrize(
    "asked",
    [
        [*MADE, move("here", "A", 3.0)],
        [*MADE, action("discover", "", "found")],
        [*MADE, action("end_day", "", "!sun")],
        [move("here", "A", 3.0), *MADE],
        MADE[:1],
    ],
    ids=["one more", "a constant changes", "an effect depends on it", "one before", "fewer"],
)
def test_other_actions_than_those_that_are_known_are_the_same_over_bits(
    asked: list[Action],
) -> None:
    """En route some come in addition, and a problem may leave others out."""
    start = facts_of("at(H)", "can", "sun", "at(here)")
    known = KnownActions(MADE)
    for actions in (MADE, asked, MADE):  # what one problem leaves behind harms no other one
        found = TransitionSystem(actions, start, known)
        for facts in reachable(actions, start):
            expected = [
                (known.state(a.apply(facts)), i, a.cost_ms)
                for i, a in enumerate(actions)
                if a.is_applicable(facts)
            ]
            assert list(found.steps(known.state(facts))) == expected


def test_an_action_is_ruled_out_by_what_never_changes() -> None:
    """A belief that is withdrawn, an event that has not come."""
    known = KnownActions(MADE)
    without = TransitionSystem(MADE, facts_of("at(H)", "can"), known)
    assert without.possible == [0, 2]
    assert TransitionSystem(MADE, facts_of("at(H)", "can", "found"), known).possible == [0, 1, 2]
