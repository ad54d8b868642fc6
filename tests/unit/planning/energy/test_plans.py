"""Whole plans on a battery, against a search that looks at every level of charge."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest
from energy_problems import energy_problem, with_skills
from problems import action, histories, problem, unit_legs
from reference_energy import EnergyReference, flown

from companion.planning.builtin.search import Search
from companion.planning.check import fault
from companion.planning.domain import WAIT, Action
from companion.planning.effort import BEFORE_FLIGHT, IN_FLIGHT
from companion.planning.energy.search import BatterySearch
from companion.planning.energy_check import energy_fault
from companion.planning.lasso import Energy, Problem

LAPS = 40
DEFAULT, ALL = 25, 240


@pytest.mark.parametrize(
    "seed",
    [*range(DEFAULT), *(pytest.param(s, marks=pytest.mark.long) for s in range(DEFAULT, ALL))],
)
def test_a_plan_is_found_if_there_is_one_and_no_lap_is_shorter(seed: int) -> None:
    judge(energy_problem(seed))


@pytest.mark.parametrize(
    "seed",
    [*range(DEFAULT), *(pytest.param(s, marks=pytest.mark.long) for s in range(DEFAULT, ALL))],
)
def test_skills_besides_make_no_plan_worse(seed: int) -> None:
    """Those that nothing asks for, and those that are done in a quick way and in a thrifty one."""
    judge(with_skills(energy_problem(seed), seed))


def judge(asked: Problem) -> None:
    """The plan that is found is right, and what is said of it."""
    best_ms = EnergyReference(asked).best_ms()
    found = list(BatterySearch(Search(asked.actions)).solutions(asked, BEFORE_FLIGHT))
    if not found:
        assert best_ms is None
        return
    solution = found[-1]
    assert fault(asked, solution.lasso, histories(asked)) is None
    assert energy_fault(asked, solution.lasso) is None
    flown(asked, solution.lasso, LAPS)
    assert best_ms is not None
    assert solution.bound_ms <= best_ms <= solution.cost_ms
    assert solution.lasso.lap_cost_ms == solution.cost_ms


def on_battery(asked: Problem, extra: Sequence[Action], level: int) -> Problem:
    """A problem with actions besides, on a battery of 99 whose flights take 3."""
    places = {fact.arguments[0]: 0 for each in asked.actions for fact in each.adds}
    energy = Energy(level, places, places, 1, [*map(float, range(100))])
    flights = [replace(each, drain=3) for each in asked.actions[:-1]]
    return replace(asked, actions=(*flights, *extra, WAIT), energy=energy)


@pytest.mark.parametrize(("level", "way"), [(99, "flash"), (14, "look")])
def test_of_two_ways_to_do_the_same_the_thrifty_one_is_known_too(level: int, way: str) -> None:
    quick = replace(action("flash", "at(A)", "seen", 1.0), drain=20)
    thrifty = replace(action("look", "at(A)", "seen", 20.0), drain=4)
    asked = on_battery(problem("HA", unit_legs("HA"), "F seen"), [quick, thrifty], level)
    *_, found = BatterySearch(Search()).solutions(asked, BEFORE_FLIGHT)
    assert [each.name for each in found.lasso.prefix] == ["move(H, A)", way]


def test_photos_that_no_line_asks_for_are_not_in_the_states_of_a_battery() -> None:
    trees = [f"t{i}" for i in range(14)]
    once = [action(f"shoot({p})", f"at({p}) & !shot({p})", f"shot({p})") for p in trees]
    sent = [action(f"send({p})", f"shot({p})", f"sent({p})") for p in trees]
    extra = [replace(each, drain=1) for each in (*once, *sent)]
    asked = problem(["H", *trees], unit_legs(["H", *trees]), "G F at(t0) & G F at(t1)")
    assert Search().product(on_battery(asked, extra, 99), IN_FLIGHT).nodes < 10 * len(trees)
