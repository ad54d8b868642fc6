"""Skills, sets, start and goal from PDDL; the example is tests/data/delivery."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from companion.acting.task_state import TaskState
from companion.errors import MissionError
from companion.ltl.parser import parse
from companion.mission.loader import load_mission
from companion.mission.model import Fly, Mission
from companion.planning.planner import Planner

ROOT = Path(__file__).parents[3]
EXAMPLE = ROOT / "tests" / "data" / "delivery"
Spoil = Callable[[str, str, str], Mission]


@pytest.fixture(scope="module")
def delivery() -> Mission:
    return load_mission(EXAMPLE / "delivery.yaml")


@pytest.fixture
def spoil(tmp_path: Path) -> Spoil:
    """Loads a copy of the example in which one text of one file is replaced."""
    folder = tmp_path / "tests" / "data" / "delivery"
    shutil.copytree(EXAMPLE, folder)
    shutil.copytree(ROOT / "missions" / "maps", tmp_path / "missions" / "maps")

    def load(name: str, old: str, new: str) -> Mission:
        text = (folder / name).read_text(encoding="utf-8")
        assert old in text
        (folder / name).write_text(text.replace(old, new), encoding="utf-8")
        return load_mission(folder / "delivery.yaml")

    return load


def test_types_are_sets_and_places_keep_their_spelling(delivery: Mission) -> None:
    assert delivery.sets["place"] == ("Home", "A", "B")
    assert delivery.sets["depot"] == ("Home",)
    assert delivery.sets["customer"] == ("A", "B")
    assert delivery.sets["parcel"] == ("p1", "p2")


def test_actions_are_skills(delivery: Mission) -> None:
    assert list(delivery.skills) == ["move", "pick_up", "drop", "hand_over"]
    move, hand_over = delivery.skills["move"], delivery.skills["hand_over"]
    assert move.parameters == (("from", "place"), ("to", "place"))
    assert move.distinct == (("from", "to"),)
    assert move.execute == Fly("to")
    assert move.cost_s is None
    assert delivery.skills["drop"].cost_s == 5
    assert len(hand_over.conditional) == 2 * 3  # parcels, effects


def test_start_and_goal(delivery: Mission) -> None:
    assert delivery.initially >= {"at(Home)", "free", "in(p1, Home)", "wants(B, p2)"}
    assert delivery.task == {"goal": parse("F (delivered(p1) & delivered(p2))")}


def test_the_parcels_are_carried_one_at_a_time(delivery: Mission) -> None:
    """Every plan is checked by the planner itself; this one is the only sensible order."""
    planner = Planner(delivery, lambda origin, goal: 10.0)
    assert str(planner.plan(*TaskState(planner).problem())) == (
        "pick_up(p1, Home), move(Home, A), hand_over(A), move(A, Home), "
        "pick_up(p2, Home), move(Home, B), hand_over(B), (wait)^w"
    )


def test_a_goal_of_the_mission_file_comes_first(spoil: Spoil) -> None:
    goal = "problem: two_parcels.pddl\ngoal: delivered(p2)"
    mission = spoil("delivery.yaml", "problem: two_parcels.pddl", goal)
    assert mission.task == {"goal": parse("F delivered(p2)")}


def test_sets_of_the_mission_file_may_have_the_members(spoil: Spoil) -> None:
    """A domain without a problem: the mission file lists the members of its types."""
    sets = (
        "objects: [p1]\nsets: {place: [Home, A], customer: [A], depot: [Home], parcel: [p1]}\n"
        'initially: [at(Home), free, "in(p1, Home)", "wants(A, p1)"]\ngoal: delivered(p1)\n'
    )
    mission = spoil("delivery.yaml", "problem: two_parcels.pddl\n", sets)
    assert mission.sets["customer"] == ("A",)


@pytest.mark.parametrize("has_metric", [False, True])
def test_costs_of_the_domain(spoil: Spoil, has_metric: bool) -> None:
    spoil("delivery.pddl", "(:action move", "(:functions (total-cost) - number) (:action move")
    if has_metric:
        goal = "(delivered p1) (delivered p2))"
        spoil("two_parcels.pddl", goal, f"{goal}) (:metric minimize (total-cost)")
    spoil("delivery.yaml", 'USER_2)", cost: 5', 'USER_2)"')
    mission = spoil(
        "delivery.pddl",
        ":effect (and (free) (not (has ?x)) (in ?x ?p))",
        ":effect (and (free) (not (has ?x)) (in ?x ?p) (increase (total-cost) 7))",
    )
    assert mission.skills["drop"].cost_s == 7


SPOILT = [
    ("delivery.yaml", "  pick_up:", "  pick:", "the domain has no action pick"),
    ("delivery.yaml", "cost: flight_time", "effect: at(to)", "effect of move stands in the domain"),
    ("delivery.yaml", "two_parcels", "three_parcels", "cannot be read: No such file"),
    ("delivery.yaml", "components:", "sets: {parcel: [A]}\ncomponents:", "parcel is a type with"),
    ("delivery.pddl", "(at ?p - place)", "(at ?p - foo)", "cannot be read as PDDL"),
    ("delivery.pddl", "(define", "((define", "cannot be read as PDDL"),
    ("delivery.pddl", "(define", "(" * 50_000, "cannot be read as PDDL"),
    ("delivery.pddl", "(define", " " * 200_000, "has more than 100000 bytes"),
    ("delivery.pddl", ":precondition (at ?c)", ":precondition (or (at ?c) (free))", "supported"),
    ("two_parcels.pddl", "(at Home) ", "", "no fact says where the vehicle is"),
    ("two_parcels.pddl", "A B - customer", "A X - customer", "cannot be read as PDDL"),
]


@pytest.mark.parametrize(("name", "old", "new", "message"), SPOILT)
def test_a_mistake_is_answered(spoil: Spoil, name: str, old: str, new: str, message: str) -> None:
    with pytest.raises(MissionError) as caught:
        spoil(name, old, new)
    assert message in str(caught.value)


def test_an_action_that_nothing_executes(spoil: Spoil) -> None:
    line = '  drop: {execute: "command(payload, MAV_CMD_USER_2)", cost: 5, timeout_s: 15}\n'
    with pytest.raises(MissionError, match="nothing says what the action drop does"):
        spoil("delivery.yaml", line, "")


def test_deep_nesting(spoil: Spoil) -> None:
    deep = "(and " * 5_000 + "(at ?c)" + ")" * 5_000
    with pytest.raises(MissionError, match="cannot be read as PDDL"):
        spoil("delivery.pddl", ":precondition (at ?c)", f":precondition {deep}")
