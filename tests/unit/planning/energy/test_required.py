"""What a plan needs, how far it charges, and what is told where a battery is too small."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from energy_problems import energy_problem
from problems import action, asking, move

from companion.battery_profile import BatteryProfile
from companion.mission.battery import MissionBattery
from companion.mission.steps import Charge
from companion.planning.builtin.search import Search
from companion.planning.charger import UNITS_PER_WH, Charger
from companion.planning.domain import WAIT, Refinement
from companion.planning.effort import BEFORE_FLIGHT
from companion.planning.energy.charged_actions import charged
from companion.planning.energy.model import FACTOR, EnergyModel
from companion.planning.energy.search import BatterySearch
from companion.planning.energy.shortage import STRANDED, shortages
from companion.planning.energy_check import energy_fault, required_levels
from companion.planning.lasso import Energy, Lasso, Problem


def best(asked: Problem) -> Lasso | None:
    found = list(BatterySearch(Search(asked.actions)).solutions(asked, BEFORE_FLIGHT))
    return found[-1].lasso if found else None


def at_level(asked: Problem, level: int) -> Problem:
    assert asked.energy is not None
    return replace(asked, energy=replace(asked.energy, level=level))


@pytest.mark.parametrize("seed", range(60))
def test_a_plan_lasts_exactly_from_what_it_requires_on(seed: int) -> None:
    asked = energy_problem(seed)
    lasso, energy = best(asked), asked.energy
    if lasso is None or energy is None:
        return
    required = required_levels(energy, asked.facts, lasso)
    assert len(required) == len(lasso.prefix) + len(lasso.loop)
    for level in range(len(energy.percents)):
        is_enough = energy_fault(at_level(asked, level), lasso) is None
        assert is_enough == (level >= required[0]), level


def two_places(full: int, drain: int = 5) -> Problem:
    """A site and a dock, which is left with what a full battery has."""
    charger = Charger(3, 1, 1, 1000, np.arange(full + 1, dtype=np.int64) * 100)
    charge = replace(action("recharge(X)", "at(X)", "at(X)"), charger=charger)
    moves = [replace(move(a, b, 2.0), drain=drain) for a, b in (("X", "A"), ("A", "X"))]
    energy = Energy(
        level=full,
        floors={"X": 3, "A": 3 + drain},
        rests={"X": 3, "A": 3},
        rest=1,
        percents=[100 * level / full for level in range(full + 1)],
    )
    asked = asking("G F at(A) & G F at(X)", [*moves, charge, WAIT], [{"at(X)"}])
    return replace(asked, energy=energy)


def test_one_unit_short_is_one_unit() -> None:
    """There and back takes 10; the battery has 14 = 3 + 10 + 1 for taking off."""
    assert best(two_places(14)) is not None
    asked = two_places(13)
    assert best(asked) is None
    (line,) = shortages(BatterySearch(Search(asked.actions)), asked, BEFORE_FLIGHT)
    assert line.startswith("A cannot be served: X, A, X takes 0.1 Wh, ")
    assert "0.01 Wh more than" in line


def test_a_charge_that_is_too_little_is_told_with_the_least_that_is_enough() -> None:
    asked = at_level(two_places(20), 2)
    assert best(asked) is None and best(at_level(asked, 3)) is not None
    (line,) = shortages(BatterySearch(Search(asked.actions)), asked, BEFORE_FLIGHT)
    assert line == "the charge, 10 %, is too little: from 15 % on there is a plan"


def test_without_a_dock_a_task_for_ever_has_none() -> None:
    asked = two_places(20)
    asked = replace(asked, actions=tuple(a for a in asked.actions if a.charger is None))
    assert shortages(BatterySearch(Search(asked.actions)), asked, BEFORE_FLIGHT) == (
        "the task goes on for ever, and nothing on its way charges",
    )


@pytest.mark.parametrize("full", [5, 9, 12])
def test_a_task_with_an_end_is_told_by_how_much_the_battery_is_too_small(full: int) -> None:
    """There and back takes 10, and 3 are the reserve: with 13 there is a plan."""

    def once(size: int) -> Problem:
        asked = two_places(size)
        moves = tuple(a for a in asked.actions if a.charger is None)
        ends = asking("F at(A) & F G at(X)", moves, [{"at(X)"}])
        return replace(ends, energy=asked.energy)

    assert best(once(13)) is not None and best(once(full)) is None
    (line,) = shortages(BatterySearch(Search(once(full).actions)), once(full), BEFORE_FLIGHT)
    more = (13 - full) / UNITS_PER_WH
    assert line == (
        f"the way to its end takes 0.1 Wh with the reserve, {more:.2f} Wh more than a full "
        "battery has"
    )


def test_where_no_way_leads_to_a_safe_place_the_charge_is_not_blamed() -> None:
    asked = two_places(20)
    assert asked.energy is not None
    cut_off = replace(asked, energy=replace(asked.energy, floors={"A": 3}))
    assert shortages(BatterySearch(Search(asked.actions)), cut_off, BEFORE_FLIGHT) == (STRANDED,)


def test_a_task_without_a_plan_anyway_is_not_the_batterys_fault() -> None:
    asked = two_places(20)
    impossible = asking("F at(Nowhere)", asked.actions, [{"at(X)"}])
    impossible = replace(impossible, energy=asked.energy)
    assert shortages(BatterySearch(Search(impossible.actions)), impossible, BEFORE_FLIGHT) == ()


def test_a_level_is_charged_to_with_a_percent_of_the_gauge_more() -> None:
    asked = two_places(300)
    assert asked.energy is not None
    (charge,) = (a for a in asked.actions if a.charger is not None)
    charge = replace(charge, execute=(Charge(None),))
    for level in range(3, 300):
        found = charged(charge, level, None, asked.energy.percents)
        (stop,) = found.execute
        assert found.charge_to == level and found.charger is not None
        assert isinstance(stop, Refinement) and stop.enough_percent is not None
        (step,) = stop.steps
        assert isinstance(step, Charge) and step.percent is not None
        top = asked.energy.percents[level + 1]
        assert min(100, top + 1) <= step.percent <= min(100, top + 2)
        assert stop.enough_percent >= asked.energy.percents[level] + 1


MODEL = EnergyModel(MissionBattery(BatteryProfile(), 0.2))


def test_what_is_there_is_rounded_down_and_what_is_taken_up() -> None:
    profile = BatteryProfile()
    for percent in range(101):
        level = MODEL.level(percent / 100)
        assert level <= 100 * profile.energy_wh(percent / 100) < level + 1
        assert MODEL.charge(level) <= percent / 100 + 1e-9
    for seconds in (0.1, 1.0, 7.3, 100.0):
        wanted = FACTOR * profile.power_w(0.0) * seconds / 36
        assert wanted <= MODEL.hovering(seconds) + 1e-6 and MODEL.hovering(seconds) < wanted + 1


def test_charging_is_the_slower_the_fuller() -> None:
    times_ms = MODEL.charging_ms([(0.0, 0.005), (0.8, 0.005), (0.9, 0.002), (1.0, 0.0)])
    assert len(times_ms) == MODEL.full + 1 and times_ms[0] == 0
    steps = np.diff(times_ms)
    assert (steps >= 0).all() and np.diff(steps).min() >= -1  # whole milliseconds
    reserve = MODEL.level(0.2)
    for percent in (40, 60, 80):  # a curve that is not convex is made so
        charged_ms = times_ms[MODEL.level(percent / 100)] - times_ms[reserve]
        assert charged_ms == pytest.approx(1000 * (percent - 20) / 0.5, rel=0.03)
