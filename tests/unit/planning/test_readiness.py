"""Lines that shall hold whenever their event may come: plans that are left, what is refused."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import replace
from random import Random
from typing import Any

import pytest
from synthetic import event, mission

from companion.errors import MissionError
from companion.ltl.parser import parse_line
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.planning.explain import NoPlan
from companion.planning.planner import Planner

SECONDS = {"HA": 10, "HB": 20, "AB": 10, "AH": 10, "BH": 20, "BA": 10}


def ready(limit: str, *others: str) -> Mission:
    """H, A and B in a row, 10 s apart; an alarm is answered at H."""
    made = mission("F at(A)", events=[event("alarm")])
    task = {"answer": parse_line(f"G (alarm -> F[<={limit}] at(H))")}
    task |= {f"line{i}": parse_line(other) for i, other in enumerate(others)}
    return replace(made, task=task, ready=("answer",))


def planner(asked: Mission) -> Planner:
    return Planner(asked, lambda a, b: SECONDS.get(a + b, 15.0))


def names(asked: Mission) -> set[str]:
    return {action.name for action in planner(asked).initial_problem()[0].actions}


ALL = {f"move({a}, {b})" for a in "HAB" for b in "HAB" if a != b} | {"wait"}


def test_what_is_too_far_from_the_answer_is_left_out() -> None:
    assert names(ready("50s")) == ALL
    assert names(ready("40s")) == ALL - {"move(H, B)"}  # 38 s are planned with, 40 are needed
    assert names(ready("31s")) == ALL - {"move(H, B)", "move(A, B)"}
    assert names(ready("21s")) == {"move(A, H)", "wait"}


def test_the_rule_holds_at_every_moment_of_a_plan() -> None:
    """Wherever the alarm comes, the step under way and the way from its end fit."""
    random = Random(3)
    for _ in range(30):
        asked = ready(f"{random.randint(20, 60)}s", "G F at(A)", "G F at(B)")
        limit_ms = 1000 * int(str(asked.task["answer"]).split("<=")[1].split("s")[0])
        try:
            plan = planner(asked).plan()
        except NoPlan:
            continue
        for action in (*plan.prefix, *plan.loop):
            end = action.arguments[-1]
            assert action.cost_ms + 1000 * SECONDS.get(f"{end}H", 0) <= limit_ms


def test_places_that_are_too_far_are_named() -> None:
    with pytest.raises(NoPlan) as none:
        planner(ready("31s", "G F at(A)", "G F at(B)")).plan()
    assert none.value.explanation.late == (
        "B is too far for answer to be ready: move(A, B) and the way to H take 30.0 s, a plan "
        "has 29 s",
    )
    assert "B is too far for answer" in str(none.value)
    assert none.value.explanation.no_route == ()  # there is one, which takes too long


def test_a_way_that_is_closed_is_none() -> None:
    made = planner(ready("40s"))
    problem, _ = made.initial_problem(without={"trans_ok(B, A)"})
    assert "move(A, B)" in {action.name for action in problem.actions}
    problem, _ = made.initial_problem(without={"trans_ok(B, A)", "trans_ok(B, H)"})
    assert "move(A, B)" not in {action.name for action in problem.actions}


def test_from_between_places_there_is_always_a_way_back() -> None:
    made = planner(ready("40s"))
    facts = frozenset(f for f in made.mission.initially if f.predicate != "at")
    states = tuple(conjunct.automaton.initial for conjunct in made.conjuncts)
    for seconds, left in ((15.0, {"A", "B", "H"}), (25.0, {"A", "H"}), (90.0, {"A", "B", "H"})):

        def flight_time(a: str, b: str, from_here_s: float = seconds) -> float:
            return from_here_s if a == "here" else SECONDS.get(a + b, 15.0)

        made.actions.flight_time = flight_time
        problem = made.problem(facts, states, is_en_route=True, clocks_ms=(None,))
        ways = {a.arguments[1] for a in problem.actions if a.arguments[:1] == ("here",)}
        assert ways == left


BASE: dict[str, Any] = {
    "version": 1,
    "name": "ready",
    "limits": {"speed_mps": 2, "up_m": [0.5, 4], "fence": [[-9, -9], [9, -9], [9, 9], [-9, 9]]},
    "places": {"H": {"east_m": 0, "north_m": 0, "up_m": 2}},
    "sets": {"Place": ["H"]},
    "events": {"alarm": {"when": "COMMAND.MAV_CMD_USER_1"}},
    "skills": {"stay": {"parameters": {"p": "Place"}, "effect": "done(p)", "execute": "wait(1)"}},
    "initially": ["at(H)"],
    "task": {"answer": "G (alarm -> F[<=90s] at(H))", "home": "G F at(H)"},
    "ready": ["answer"],
}


AWAY = {"east_m": 5, "north_m": 0, "up_m": 2, "radius_m": 3, "found_by": "alarm"}


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"ready": ["anwser"]}, "ready[0]: no line of the task is called anwser"),
        ({"ready": ["answer", "answer"]}, "ready[1]: answer is twice in ready"),
        ({"ready": ["home"]}, "ready[0]: home is not a line that can be ready: G F at(H)"),
        (
            {"task": {"answer": "G (alarm -> F[<=9s] !alarm)"}},
            "ready[0]: answer can only be ready for a place, and asks for !alarm",
        ),
        (
            {"task": {"answer": "F[<=9s] at(H)"}},
            "ready[0]: answer is not a line that can be ready: F[<=9s] at(H)",
        ),
        (
            {
                "task": {
                    "answer": {"formula": "G (alarm -> F[<=9s] at(H))", "priority": 1},
                    "home": "G F at(H)",
                }
            },
            "ready[0]: answer may be dropped, so no plan keeps it ready",
        ),
        ({"tree": ["stay(H)"]}, "ready[0]: answer stands beside a tree by hand"),
        (
            {
                "places": BASE["places"] | {"P": AWAY},
                "events": {"alarm": {"when": "EVENT[p] > 0", "latch": True}},
                "task": {"answer": "G (alarm -> F[<=90s] at(P))", "home": "G F at(H)"},
            },
            "ready[0]: answer cannot be ready: nobody knows where P is before it is found",
        ),
    ],
)
def test_what_cannot_be_ready_is_refused(change: dict[str, Any], what: str) -> None:
    assert load_mission(deepcopy(BASE)).ready == ("answer",)
    with pytest.raises(MissionError) as error:
        load_mission(deepcopy(BASE) | change)
    assert str(error.value).startswith(what)
    assert error.value.hint
