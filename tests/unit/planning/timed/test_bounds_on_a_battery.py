"""Plans that keep bounds and a reserve: all are right, and "none" is said where there is none."""

from __future__ import annotations

from dataclasses import replace
from random import Random
from typing import Any

import pytest
from energy_problems import energy_problem
from problems import histories
from ready_problems import by_definition, planned_for, ready_problem
from reference_energy import EnergyReference, flown
from reference_time import TimeReference
from timed_problems import with_bounds
from two_docks import two_docks

from companion.errors import SearchLimit
from companion.ltl.parser import parse
from companion.ltl.time_bounds import Response, Revisit, TimeBound, Within
from companion.mission.loader import load_mission
from companion.planning.builtin.product import Product
from companion.planning.builtin.search import Search
from companion.planning.check import fault
from companion.planning.effort import BEFORE_FLIGHT, IN_FLIGHT
from companion.planning.energy.search import BatterySearch
from companion.planning.energy_check import energy_fault
from companion.planning.lasso import Problem, Solution
from companion.planning.planner import Planner
from companion.planning.time_check import time_fault
from companion.planning.timed import lassos
from companion.planning.timed.charge_levels import levels_of
from companion.planning.timed.lap_search import LapSearch
from companion.planning.timed.search import TimedSearch

LAPS = 20


def bounded(seed: int, share: float) -> Problem:
    """A problem on a battery with one bound, of about some share of what its lap takes."""
    asked, chance = energy_problem(seed), Random(seed)
    lap_ms = EnergyReference(asked).best_ms() or 60_000
    added = {fact for action in asked.actions for fact in action.adds if fact.predicate == "at"}
    goal, trigger = (parse(text) for text in chance.sample(sorted(map(str, added)), 2))
    limit_ms = round(share * chance.uniform(0.7, 1.3) * lap_ms) + 4000
    bounds: tuple[TimeBound, ...] = (
        Revisit(goal, limit_ms),
        Revisit(goal, limit_ms),
        Within(goal, limit_ms),
        Response(goal, limit_ms, trigger),
    )
    return with_bounds(asked, {"line": chance.choice(bounds)}, asked.facts)


def planned(asked: Problem) -> Solution | None:
    """The last plan that is found; all are right."""
    found = list(TimedSearch(BatterySearch(Search(asked.actions))).solutions(asked, BEFORE_FLIGHT))
    for solution in found:
        assert fault(asked, solution.lasso, histories(asked)) is None
        assert energy_fault(asked, solution.lasso) is None
        assert time_fault(asked, solution.lasso) is None
        assert solution.bound_ms <= solution.cost_ms == solution.lasso.lap_cost_ms
        flown(asked, solution.lasso, LAPS)
    return found[-1] if found else None


@pytest.mark.parametrize(
    "seed",
    [*range(6), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(6, 240))],
)
def test_a_plan_keeps_both(seed: int) -> None:
    asked = bounded(seed, share=1.0)
    best_ms = EnergyReference(asked).best_ms()
    try:
        solution = planned(asked)
    except SearchLimit as reached:
        assert best_ms is not None
        assert "no proof" in str(reached)
        return
    if solution is None:
        without_battery = TimeReference(replace(asked, energy=None)).best_ms()
        assert best_ms is None or without_battery is None
        return
    assert best_ms is not None
    assert solution.bound_ms <= best_ms <= solution.cost_ms


@pytest.mark.parametrize(
    "seed",
    [*range(10), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(10, 130))],
)
def test_a_plan_keeps_both_and_the_charge_for_an_answer(seed: int) -> None:
    asked, (_, line) = bounded(seed, share=1.2), ready_problem(seed)
    meant, problem = by_definition(asked, line), planned_for(asked, line)
    try:
        solution = planned(problem)
    except SearchLimit as reached:
        assert "no proof" in str(reached)
        return
    if solution is not None:
        flown(meant, solution.lasso, LAPS)
        assert (EnergyReference(meant).best_ms() or 0) <= solution.cost_ms


@pytest.mark.long
def test_many_plans_are_found() -> None:
    found = 0
    for seed in range(20):
        try:
            found += planned(bounded(seed, share=1.0)) is not None
        except SearchLimit:
            continue
    assert found >= 6


def test_the_lap_of_the_battery_alone_is_entered_where_the_bounds_allow_it() -> None:
    """Its charges are none of the few that are tried; begun with one it comes too late to C."""
    task = {"patrol": "patrolling(A, B, C)", "often": "revisit(W) <= 26 s", "c": "F[<=35s] at(C)"}
    data = two_docks(task=task)
    spots = {"A": (16, 23), "B": (22, 25), "C": (33, 0), "W": (15, 20), "E": (3, 28)}
    for name, (east_m, north_m) in spots.items():
        up_m = 2 if name in data["sets"]["Pad"] else 3
        data["places"][name] = {"east_m": east_m, "north_m": north_m, "up_m": up_m}
    data["sets"]["Place"] = list(data["places"])
    plan = Planner(load_mission(data)).plan()
    assert [action.name for action in plan.loop].count("recharge(W)") == 1
    assert plan.is_optimal or plan.bound_ms == plan.cost_ms


@pytest.mark.parametrize("seed", range(10))
def test_one_product_is_searched_with_bounds_and_without(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[Product] = []

    def noted(self: Search, *arguments: Any, **keys: Any) -> Product:
        made.append(product(self, *arguments, **keys))
        return made[-1]

    product = Search.product
    monkeypatch.setattr(Search, "product", noted)
    asked = bounded(seed, share=0.9)
    search = TimedSearch(BatterySearch(Search(asked.actions)))
    found = search.is_solvable(asked, IN_FLIGHT)
    assert len(made) == 1 or not found  # one more without a battery, if there is no plan


def test_with_another_charge_laps_are_not_searched_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """The lower charge makes the way into the lap charge, to a level that depends on it."""
    made: list[LapSearch] = []

    def noted(*arguments: Any, **keys: Any) -> LapSearch:
        made.append(LapSearch(*arguments, **keys))
        return made[-1]

    monkeypatch.setattr(lassos, "LapSearch", noted)
    asked = bounded(34, share=0.35)
    assert asked.energy is not None
    full, lower = (replace(asked, energy=replace(asked.energy, level=level)) for level in (21, 10))
    battery = BatterySearch(Search(asked.actions))
    best = [next(battery.solutions(each, IN_FLIGHT)).lasso for each in (full, lower)]
    assert levels_of(best[1].prefix) - levels_of(best[1].loop)
    assert levels_of(best[0].loop) == levels_of(best[1].loop)
    search = TimedSearch(battery)
    assert search.is_solvable(full, IN_FLIGHT) is None
    assert made
    made.clear()
    assert search.is_solvable(lower, IN_FLIGHT) is None
    assert not made
