"""What is lent of the reserve in flight, where nothing is left above it."""

from __future__ import annotations

from typing import Any

import pytest
from two_docks import two_docks

from companion.mission.loader import load_mission
from companion.planning.energy.mission_energy import MissionEnergy
from companion.planning.lasso import Problem
from companion.planning.planner import Planner
from companion.planning.skill_trials import SkillTrials
from companion.planning.task_state import TaskState

FAR = 50
"""Units above the reserve, or below."""


class Told:
    """A charge that is known exactly; fulfils `ChargeSource`."""

    def __init__(self, level: int, is_flown: bool) -> None:
        self._level, self.is_flown = level, is_flown

    def least(self) -> int:
        return self._level

    most = middle = least


def planner_at(missing: int, place: str = "B", is_flown: bool = True, **changes: Any) -> Planner:
    """With so much less than it takes to land at a safe place with the reserve left."""
    planner = Planner(load_mission(two_docks(**changes)))
    energy = energy_of(planner)
    level = energy.now(is_en_route=False).floors[place] - missing
    energy.charge = Told(level, is_flown)
    return planner


def energy_of(planner: Planner) -> MissionEnergy:
    assert planner.energy is not None
    return planner.energy


def problem_at(planner: Planner, place: str = "B") -> Problem:
    return planner.initial_problem(at=place)[0]


def lent(planner: Planner, place: str = "B") -> int:
    energy = problem_at(planner, place).energy
    assert energy is not None
    assert energy.level - energy.borrowed == energy_of(planner).charge.least()
    return energy.borrowed


@pytest.mark.parametrize("missing", [1, FAR, 500])
def test_a_plan_charges_first_where_that_takes_the_least(missing: int) -> None:
    """It is the plan of one that has just enough, but for what is lent."""
    planner = planner_at(missing)
    assert missing < lent(planner) < missing + 20
    lasso = planner.solver.replan(*planner.initial_problem(at="B"))
    assert lasso is not None
    assert [a.name for a in (*lasso.prefix, *lasso.loop)][:2] == ["move(B, E)", "recharge(E)"]


BOUNDED = {"task": {"a": "revisit(A) <= 900 s", "b": "G F at(B)"}}
READY: dict[str, Any] = {
    "task": {"patrol": "patrolling(A, B)", "answer": "G (alarm -> F[<=60s] at(A))"},
    "events": {"alarm": {"when": "COMMAND.MAV_CMD_USER_1"}},
    "ready": ["answer"],
}


@pytest.mark.parametrize("missing", [0, 1, FAR])
@pytest.mark.parametrize("changes", [BOUNDED, READY])
def test_so_it_does_where_lines_have_bounds_or_are_ready(
    missing: int, changes: dict[str, Any]
) -> None:
    planner = planner_at(missing, **changes)
    lasso = planner.solver.replan(*planner.initial_problem(at="B"))
    assert lasso is not None
    assert [a.name for a in (*lasso.prefix, *lasso.loop)][:2] == ["move(B, E)", "recharge(E)"]


@pytest.mark.parametrize("more", [0, FAR])
def test_what_lasts_for_a_landing_alone_lasts_for_a_charge(more: int) -> None:
    planner = planner_at(-more)
    assert lent(planner) == 0
    assert planner.solver.replan(*planner.initial_problem(at="B")) is not None


def test_nothing_is_lent_on_the_ground() -> None:
    planner = planner_at(1, is_flown=False)
    assert lent(planner) == 0
    assert planner.solver.replan(*planner.initial_problem(at="B")) is None


def test_no_more_is_lent_than_the_reserve() -> None:
    reserve = energy_of(planner_at(0)).model.reserve
    assert lent(planner_at(reserve + 1)) == 0
    assert lent(planner_at(reserve - FAR)) <= reserve


def test_no_farther_dock_is_reached_on_the_reserve() -> None:
    """Home takes the least, and nothing charges there."""
    places = two_docks()["places"] | {"Home": {"east_m": 28, "north_m": 0, "up_m": 3}}
    planner = planner_at(1, "A", places=places)
    assert lent(planner, "A") == 1
    assert planner.solver.replan(*planner.initial_problem(at="A")) is None


def test_no_line_of_the_task_is_dropped_for_it() -> None:
    task = {"a": {"formula": "G F at(A)", "priority": 1}, "b": "G F at(B)"}
    planner = planner_at(FAR, task=task)
    assert planner.solver.lines_to_drop(problem_at(planner)) == ()


@pytest.mark.parametrize("place", ["A", "B"])
def test_of_two_docks_the_nearer_one_counts_in_whatever_order_they_are_named(place: str) -> None:
    """A skill that flies to its dock itself begins where the vehicle is, for each dock."""
    given = two_docks()
    given["skills"]["recharge"] |= {
        "parameters": {"from": "Place", "pad": "Pad"},
        "precondition": "at(from)",
        "effect": "at(pad) & !at(from)",
        "execute": ["fly(pad)", "land()", "charge(auto)", "take_off()"],
    }
    skills, found = given["skills"], []
    for docks in (["W", "E"], ["E", "W"]):
        sets = {**given["sets"], "Pad": docks}
        found.append(lent(planner_at(FAR, place, skills=skills, sets=sets), place))
    assert found[0] == found[1] < FAR + 5


def test_a_barred_dock_does_not_decide_how_much_is_lent() -> None:
    """Nobody charges there, so the landing alone counts."""
    planner = planner_at(FAR)
    state = TaskState(planner)
    move = next(a for a in planner.actions.every() if a.name == "move(Home, B)")
    state.begin(move)
    state.complete(move, 10.0)
    assert FAR < lent_in(state.problem()[0])
    state.bar(next(a for a in planner.actions.every() if a.name == "recharge(E)"))
    problem, histories = state.problem()
    assert lent_in(problem) == FAR
    assert planner.solver.replan(problem, histories) is None


def test_after_an_answer_nobody_goes_on_to_a_barred_dock() -> None:
    """W is nearer to A, where the answer is, so E demands more."""
    planner = planner_at(-FAR, **READY)
    asked, states = problem_at(planner), problem_at(planner).automaton_states
    trials = SkillTrials(barred=frozenset({"recharge(W)"}))
    barred = planner.problem(asked.facts, states, trials=trials)
    assert asked.energy is not None and barred.energy is not None
    assert asked.energy.ready["A"] < barred.energy.ready["A"]


def lent_in(problem: Problem) -> int:
    assert problem.energy is not None
    return problem.energy.borrowed
