"""Skills become actions: bindings, beliefs, costs, and the place between places."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from synthetic import command, facts_of, mission, move, skill

from companion.mission.facts import HERE, Fact
from companion.mission.model import Mission
from companion.mission.steps import Command, Fly, Wait
from companion.planning.domain import WAIT, Action
from companion.planning.instances import departures, instantiate


def four_seconds(origin: str, goal: str) -> float:
    return 4.0


def actions(asked: Mission) -> dict[str, Action]:
    return {a.name: a for a in instantiate(asked, four_seconds).actions}


def test_a_move_exists_for_every_pair_of_places_and_none_to_where_it_is() -> None:
    assert list(actions(mission("F at(A)", places="HAB"))) == [
        "move(H, A)",
        "move(H, B)",
        "move(A, H)",
        "move(A, B)",
        "move(B, H)",
        "move(B, A)",
        "wait",
    ]


def test_an_action_is_its_skill_with_the_parameters_filled_in() -> None:
    found = actions(mission("F at(A)", skills=[move(tries=5, timeout_s=30.0)]))["move(H, A)"]
    assert found == Action(
        skill="move",
        arguments=("H", "A"),
        requires=facts_of("at(H)", "trans_ok(H, A)"),
        forbids=frozenset(),
        assumes=facts_of("trans_ok(H, A)"),
        adds=facts_of("at(A)"),
        deletes=facts_of("at(H)"),
        cost_ms=4000,
        execute=(Fly("A"),),
        tries=5,
        timeout_s=30.0,
        departure=0,
    )


def test_negated_facts_forbid_and_delete() -> None:
    drop = command("drop", "loaded & !low & at(A)", "!loaded & delivered")
    found = actions(mission("F at(A)", skills=[drop]))["drop"]
    assert found.requires == {"loaded", "at(A)", "can_drop"}
    assert found.forbids == {"low"}
    assert found.adds == {"delivered"}
    assert found.deletes == {"loaded"}


def test_beliefs_are_what_the_actions_assume() -> None:
    model = instantiate(mission("F at(A)", skills=[command("do")]), four_seconds)
    moves = {f"trans_ok({a}, {b})" for a in "HAB" for b in "HAB" if a != b}
    assert model.beliefs == moves | {"can_do"}


def test_a_parameter_takes_every_member_of_its_set() -> None:
    look = skill("look", Wait(2.0), "p", "at(p)", effect="seen(p)")
    found = actions(mission("F at(A)", skills=[look]))
    assert {n for n in found if n.startswith("look")} == {"look(H)", "look(A)", "look(B)"}
    assert found["look(A)"].requires == {"at(A)"}
    assert found["look(A)"].adds == {"seen(A)"}
    assert found["look(A)"].execute == (Wait(2.0),)


def test_what_is_required_and_forbidden_at_once_does_not_exist() -> None:
    swap = skill("swap", Wait(1.0), "p q", "at(p) & !at(q)")
    found = [n for n in actions(mission("F at(A)", skills=[swap])) if n.startswith("swap")]
    assert len(found) == 6  # of 9: not with p = q


def test_what_is_added_and_deleted_is_added() -> None:
    stay = skill("stay", Wait(1.0), "p q", "at(p)", effect="at(q) & !at(p)")
    found = actions(mission("F at(A)", skills=[stay]))["stay(A, A)"]
    assert found.apply(facts_of("at(A)")) == {"at(A)"}


def test_a_flight_without_a_way_does_not_exist() -> None:
    def walled(origin: str, goal: str) -> float:
        return math.inf if goal == "B" else 4.0

    model = instantiate(mission("F at(A)"), walled)
    assert [a.name for a in model.actions if "B" in a.name] == ["move(B, H)", "move(B, A)"]
    assert "trans_ok(H, B)" not in model.beliefs


@pytest.mark.parametrize(
    ("flight_s", "cost_ms"), [(4.04, 4000), (4.06, 4100), (0.01, 200), (0.0, 200)]
)
def test_costs_are_rounded_to_tenths_of_a_second_and_are_above_that_of_rest(
    flight_s: float, cost_ms: int
) -> None:
    model = instantiate(mission("F at(A)"), lambda origin, goal: flight_s)
    assert {a.cost_ms for a in model.actions if a is not WAIT} == {cost_ms}


def test_a_cost_that_is_written_down_counts() -> None:
    assert actions(mission("F at(A)", skills=[command("do", cost_s=7.5)]))["do"].cost_ms == 7500


def test_a_command_keeps_its_numbers() -> None:
    (found,) = actions(mission("F at(A)", skills=[command("do")]))["do"].execute
    assert isinstance(found, Command)
    assert (found.component, found.command, found.parameters) == (25, 31010, (1.5, -2.0))


def test_wait_is_an_action_that_is_always_there_and_changes_nothing() -> None:
    model = instantiate(mission("F at(A)"), four_seconds)
    assert model.actions[-1] is WAIT
    facts = facts_of("at(A)", "found")
    assert WAIT.is_applicable(frozenset()) and WAIT.apply(facts) == facts


# -- from here -------------------------------------------------------------------------------------


def test_departures_lead_from_here_to_every_place_at_the_cost_from_here() -> None:
    asked: list[tuple[str, str]] = []

    def flight_time(origin: str, goal: str) -> float:
        asked.append((origin, goal))
        return {"H": 1.0, "A": 2.0, "B": math.inf}[goal]

    found = departures(mission("F at(A)"), flight_time)
    assert [(a.name, a.cost_ms) for a in found] == [
        ("move(here, H)", 1000),
        ("move(here, A)", 2000),
    ]
    assert asked == [(HERE, place) for place in "HAB"]


def test_only_flying_skills_that_start_somewhere_depart() -> None:
    jump = skill("jump", Fly("to"), "to", "ready", effect="at(to)")
    look = skill("look", Wait(1.0), "p", "at(p)")
    asked = mission("F at(A)", skills=[move(), jump, look])
    assert {a.skill for a in departures(asked, four_seconds)} == {"move"}


@pytest.mark.parametrize(
    ("precondition", "origin"),
    [
        ("at(from)", "from"),
        ("ready & at(from)", "from"),
        ("!at(from)", None),
        ("at(A)", None),
        ("ready", None),
    ],
)
def test_where_a_skill_starts(precondition: str, origin: str | None) -> None:
    assert move(precondition=precondition).origin == origin


def test_a_flight_that_starts_anywhere_costs_what_it_says() -> None:
    """Without at(from) nobody knows how far it is: only a written cost makes sense."""
    jump = replace(move(precondition="ready"), cost_s=6.0)
    asked = mission("F at(A)", skills=[jump], initially=["at(H)", "ready"])
    found = actions(asked)["move(A, B)"]
    assert found.cost_ms == 6000


FACTS = st.frozensets(
    st.sampled_from(sorted(facts_of("at(H)", "at(A)", "at(B)", "found", "trans_ok(H, A)")))
)


@given(FACTS)
def test_an_action_changes_its_effects_and_nothing_else(facts: frozenset[Fact]) -> None:
    for action in instantiate(mission("F at(A)"), four_seconds).actions:
        after = action.apply(facts)
        assert action.adds <= after
        assert action.deletes.isdisjoint(after)
        assert after ^ facts <= action.adds | action.deletes
        assert action.is_applicable(facts) == (action.requires <= facts)
