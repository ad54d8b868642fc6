"""Whole plans with bounds in time, against a search that looks at every state of the clocks."""

from __future__ import annotations

from functools import cache

import pytest
from problems import action, histories, problem, unit_legs
from reference_time import TimeReference
from timed_problems import later, timed_problem, with_bounds

from companion.ltl.parser import parse
from companion.ltl.time_bounds import Within
from companion.planning.builtin.search import Search
from companion.planning.check import fault
from companion.planning.effort import BEFORE_FLIGHT, IN_FLIGHT
from companion.planning.energy.search import BatterySearch
from companion.planning.lasso import Problem, Solution
from companion.planning.time_check import time_fault
from companion.planning.timed.search import TimedSearch

LARGE = {10, 12, 20, 38, 41}
"""Seeds with the most states of the clocks, which take half of the time; they are long."""


def seeds(few: range, more: range) -> list[object]:
    """The first ones, and more of them for sweeps."""
    longer = LARGE.intersection(few) | {*more}
    return [
        pytest.param(seed, marks=[pytest.mark.long] if seed in longer else [])
        for seed in (*few, *more)
    ]


def planned(asked: Problem) -> Solution | None:
    """The best plan that is found; it is right."""
    found = list(TimedSearch(BatterySearch(Search(asked.actions))).solutions(asked, BEFORE_FLIGHT))
    for solution in found:
        assert fault(asked, solution.lasso, histories(asked)) is None
        assert time_fault(asked, solution.lasso) is None
    return found[-1] if found else None


@cache
def planned_for(seed: int) -> Solution | None:
    """For a random problem."""
    return planned(timed_problem(seed))


@pytest.mark.parametrize("seed", seeds(range(25), range(25, 100)))
def test_a_plan_is_found_if_there_is_one_and_no_lap_is_shorter(seed: int) -> None:
    asked = timed_problem(seed)
    best_ms = TimeReference(asked).best_ms()
    solution = planned_for(seed)
    assert (solution.cost_ms if solution else None) == best_ms
    if solution is not None:
        assert solution.bound_ms <= solution.cost_ms == solution.lasso.lap_cost_ms


@pytest.mark.parametrize("seed", seeds(range(8), range(8, 400)))
def test_plans_made_anew_are_as_good(seed: int) -> None:
    """With the laps that are known, and without them; where none is left, what is kept in hand."""
    begun = timed_problem(seed)
    search = TimedSearch(BatterySearch(Search(begun.actions)))
    list(search.solutions(begun, BEFORE_FLIGHT))
    reached = later(begun, seed)
    if reached is None:
        return
    asked, letters = reached
    best_ms = TimeReference(asked).best_ms()
    for effort, used in (
        (IN_FLIGHT, search),
        (BEFORE_FLIGHT, TimedSearch(BatterySearch(Search(begun.actions)))),
    ):
        found = list(used.solutions(asked, effort))
        for solution in found:
            assert fault(asked, solution.lasso, [letters] * len(asked.conjuncts)) is None
            assert time_fault(asked, solution.lasso) is None
        if best_ms is not None:
            assert found[-1].cost_ms == best_ms


@pytest.mark.long
def test_bounded_laps_may_visit_a_place_several_times() -> None:
    """Among the random problems are many without a plan, and some with a lap beyond the tour."""
    without, longer = 0, 0
    for seed in {*range(50)} - LARGE:
        asked = timed_problem(seed)
        solution = planned_for(seed)
        if solution is None:
            without += 1
            continue
        *_, untimed = Search(asked.actions).solutions(asked)
        longer += solution.cost_ms > untimed.cost_ms
    assert without >= 10
    assert longer >= 3


def test_a_skill_that_is_quicker_than_a_rest_may_be_what_keeps_a_bound() -> None:
    """A rest of one step takes 1 s."""
    skill = action("nod", "at(A)", "nodded", 0.2)
    asked = problem("HAB", unit_legs("HAB"), "!at(B) U (at(A) & X (at(A) & X at(B)))", [skill])
    bound = Within(parse("at(B)"), 4500)
    found = planned(with_bounds(asked, {"soon": bound}, asked.facts))
    assert found is not None
    assert "nod" in [each.name for each in found.lasso.prefix]
