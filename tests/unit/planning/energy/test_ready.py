"""Lines that are ready on a battery: plans against a search by definition, and what is told."""

from __future__ import annotations

from dataclasses import replace

import pytest
from problems import histories
from ready_problems import by_definition, planned_for, ready_problem
from reference_energy import EnergyReference, flown
from two_docks import two_docks

from companion.mission.facts import Fact
from companion.mission.loader import load_mission
from companion.planning.builtin.search import Search
from companion.planning.check import fault
from companion.planning.effort import BEFORE_FLIGHT
from companion.planning.energy.ready_levels import is_cautious
from companion.planning.energy.search import BatterySearch
from companion.planning.energy_check import energy_fault
from companion.planning.explain import NoPlan
from companion.planning.lasso import Problem
from companion.planning.planner import Planner

LAPS = 20


@pytest.mark.parametrize(
    "seed",
    [*range(20), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(20, 240))],
)
def test_a_plan_keeps_the_charge_for_the_answer_wherever_the_event_comes(seed: int) -> None:
    asked, line = ready_problem(seed)
    meant, problem = by_definition(asked, line), planned_for(asked, line)
    assert [a.name for a in problem.actions] == [a.name for a in meant.actions]
    best_ms = EnergyReference(meant).best_ms()
    found = list(BatterySearch(Search(problem.actions)).solutions(problem, BEFORE_FLIGHT))
    if not found:
        assert best_ms is None or is_cautious(problem)
        return
    solution = found[-1]
    assert fault(problem, solution.lasso, histories(problem)) is None
    assert energy_fault(problem, solution.lasso) is None
    flown(meant, solution.lasso, LAPS)
    assert best_ms is not None and best_ms <= solution.cost_ms
    assert is_cautious(problem) or solution.bound_ms <= best_ms


def patrol(limit_s: int = 40, **changes: object) -> Planner:
    """Two sites and two docks, where an alarm is answered at one of the sites."""
    task = {"patrol": "patrolling(A, B)", "answer": f"G (alarm -> F[<={limit_s}s] at(A))"}
    events = {"alarm": {"when": "COMMAND.MAV_CMD_USER_1"}}
    return Planner(
        load_mission(two_docks(**({"task": task, "events": events, "ready": ["answer"]} | changes)))
    )


def at_level(
    planner: Planner, place: str, level: int
) -> tuple[Problem, list[list[frozenset[Fact]]]]:
    problem, letters = planner.initial_problem(at=place)
    assert problem.energy is not None
    return replace(problem, energy=replace(problem.energy, level=level)), letters


def test_what_an_answer_has_used_up_is_charged_again_first() -> None:
    planner = patrol()
    answered, letters = at_level(planner, "A", 1600)
    energy = answered.energy
    assert energy is not None and energy.floors["A"] < energy.ready["A"] < 1600
    assert not planner.solver.is_solvable(answered)
    lasso = planner.solver.replan(answered, letters)
    assert lasso is not None and any(action.charger is not None for action in lasso.prefix)
    short = replace(answered, energy=replace(energy, is_short=True))
    assert energy_fault(answered, lasso) and energy_fault(short, lasso) is None
    kept = planner.solver.replan(*at_level(planner, "A", 2500))
    assert kept is not None and energy_fault(answered, lasso) is not None


def test_a_charge_says_with_how_much_the_event_ends_it() -> None:
    planner = patrol()
    (charge,) = (
        str(action.execute) for action in planner.plan().loop if action.charger is not None
    )
    assert "called_percent=24" in charge
    (charge,) = (str(action.execute) for action in patrol(ready=[]).plan().loop if action.charger)
    assert "called_percent=None" in charge


def test_what_a_line_takes_to_be_ready_is_told() -> None:
    planner = patrol()
    with pytest.raises(NoPlan) as none:
        planner.solver.solve(*at_level(planner, "Home", 1620))
    assert none.value.explanation.shortages[-1] == (
        "without ready: there would be a plan; for answer E keeps 0.88 Wh more than it takes to "
        "land at a safe place: for the way to A, and on to a dock"
    )


def test_a_dock_from_which_the_answer_is_too_far_is_told() -> None:
    with pytest.raises(NoPlan) as none:
        patrol(20).plan()
    assert (
        "W is too far for answer to be ready: recharge(W) and the way to A take 18.3 s, a plan has "
        "18 s"
    ) in none.value.explanation.late


def test_after_an_answer_it_is_charged_no_further_than_other_bounds_leave_time_for() -> None:
    """To a fifth of the battery, as the levels are that are tried, it would take two minutes."""
    task = {
        "patrol": "patrolling(A, B)",
        "answer": "G (alarm -> F[<=30s] at(A))",
        "often": "revisit(B) <= 75 s",
    }
    data = two_docks(task=task, ready=["answer"], events={"alarm": {"when": "EVENT[alarm] > 0"}})
    data["skills"]["recharge"]["charge_rate"] = [[0, 0.14], [80, 0.12], [100, 0.01]]
    planner = Planner(load_mission(data))
    answered, letters = at_level(planner, "A", 1600)
    clocks_ms = tuple(15_000 if c.name == "often" else None for c in answered.conjuncts)
    lasso = planner.solver.replan(replace(answered, clocks_ms=clocks_ms), letters)
    assert lasso is not None and any(action.charger is not None for action in lasso.prefix)
