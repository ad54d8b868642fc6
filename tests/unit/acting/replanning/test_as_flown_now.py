"""The rest of a plan with what flights take now: whether its bounds will be kept, on a battery."""

from __future__ import annotations

from dataclasses import replace

from two_docks import two_docks

from companion.acting.replanning.late_plans import as_flown_now
from companion.mission.loader import load_mission
from companion.planning.domain import Action
from companion.planning.lasso import Lasso, Problem
from companion.planning.planner import Planner
from companion.planning.time_check import longest_waits, time_fault

TASK = {"patrol": "patrolling(A, B)", "often": "revisit(A) <= 60 s"}


def planned(task: dict[str, str]) -> tuple[Problem, Lasso]:
    planner = Planner(load_mission(two_docks(task=task)))
    problem, _ = planner.initial_problem()
    return problem, planner.plan().lasso


def test_charges_last_as_long_as_the_plan_says() -> None:
    """Without how far it charges a lap would end with less for ever, and the check as well."""
    problem, lasso = planned(TASK)
    flown = as_flown_now(problem, lasso)
    assert [a.charge_to for a in flown.loop] == [a.charge_to for a in lasso.loop]
    assert longest_waits(problem, flown) == longest_waits(problem, lasso)
    assert time_fault(problem, flown) is None


def test_what_flights_take_now_is_found_to_be_late() -> None:
    problem, lasso = planned(TASK)

    def slow(action: Action) -> Action:
        return replace(action, cost_ms=4 * action.cost_ms) if action.skill == "move" else action

    slower = replace(problem, actions=tuple(map(slow, problem.actions)))
    fault = time_fault(slower, as_flown_now(slower, lasso))
    assert fault is not None and fault.startswith("often: revisit(A) <= 60 s is late by")


def test_the_check_ends_where_nothing_charges() -> None:
    problem, lasso = planned(TASK)
    bare = tuple(replace(a, charge_to=None) if a.charger else a for a in lasso.loop)
    assert time_fault(problem, Lasso(lasso.prefix, bare)) is None


def test_more_is_taken_than_there_can_be() -> None:
    """Flights take so much more that the levels of the plan are none of a battery."""
    problem, lasso = planned(TASK)
    assert problem.energy is not None
    thirsty = replace(
        problem, actions=tuple(replace(a, drain=40 * a.drain) for a in problem.actions)
    )
    fault = time_fault(thirsty, as_flown_now(thirsty, lasso))
    assert fault is not None and fault.startswith("often: revisit(A) <= 60 s is late by")
