"""Laps that were found before are taken where a search would find none that is shorter."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from random import Random
from typing import Any

import pytest
from energy_problems import energy_problem
from problems import histories

from companion.planning.builtin.search import Search
from companion.planning.check import fault
from companion.planning.domain import Action
from companion.planning.effort import BEFORE_FLIGHT, IN_FLIGHT
from companion.planning.energy import lassos
from companion.planning.energy.charging_loops import ChargingLoop, best_loops
from companion.planning.energy.search import BatterySearch
from companion.planning.energy_check import energy_fault
from companion.planning.lasso import Problem, Solution

DEFAULT, ALL = 12, 400
CHANGES = 6


def changed(problem: Problem, chance: Random) -> Problem:
    """Another charge, and maybe fewer actions, dearer or quicker ones, or lower floors."""
    energy = problem.energy
    assert energy is not None
    level = chance.randint(min(energy.floors.values(), default=0), len(energy.percents) - 1)
    floors, actions = dict(energy.floors), list(problem.actions)
    match chance.choice(("level", "level", "fewer", "dearer", "quicker", "floors")):
        case "fewer":
            gone = set(chance.sample(range(len(actions) - 1), 2))
            actions = [action for i, action in enumerate(actions) if i not in gone]
        case "dearer":
            actions = [_priced(action, chance, 1) for action in actions]
        case "quicker":
            actions = [_priced(action, chance, -1) for action in actions]
        case "floors":
            floors = {place: floor - 1 for place, floor in floors.items()}
    energy = replace(energy, level=level, floors=floors)
    return replace(problem, actions=tuple(actions), energy=energy)


def _priced(action: Action, chance: Random, step: int) -> Action:
    if action.charger is not None or chance.random() < 0.8:
        return action
    drain = action.drain + max(0, step)  # less would be less than floors say
    return replace(action, drain=drain, cost_ms=max(200, action.cost_ms + 100 * step))


def solved(problem: Problem, search: BatterySearch) -> Solution | None:
    return next(search.solutions(problem, IN_FLIGHT), None)


@pytest.mark.parametrize(
    "seed",
    [*range(DEFAULT), *(pytest.param(s, marks=pytest.mark.long) for s in range(DEFAULT, ALL))],
)
def test_a_lap_from_before_is_as_short_as_one_that_is_searched_anew(seed: int) -> None:
    problem, chance = energy_problem(seed), Random(seed)
    remembers = BatterySearch(Search(problem.actions))
    solved(problem, remembers)
    for _ in range(CHANGES):
        asked = changed(problem, chance)
        kept = solved(asked, remembers)
        anew = solved(asked, BatterySearch(remembers.plain))
        assert (kept is None) == (anew is None)
        if kept is None or anew is None:
            continue
        assert kept.cost_ms == anew.cost_ms and kept.bound_ms <= anew.cost_ms
        assert kept.lasso.prefix_cost_ms == anew.lasso.prefix_cost_ms or kept.loop != anew.loop
        assert fault(asked, kept.lasso, histories(asked)) is None
        assert energy_fault(asked, kept.lasso) is None


def test_only_what_may_have_a_shorter_lap_is_searched(monkeypatch: pytest.MonkeyPatch) -> None:
    """The charge, and what has gone beside the lap, changes nothing of it."""
    searched: list[tuple[Any, ...]] = []

    def noted(*asked: Any) -> Iterator[ChargingLoop]:
        searched.append(asked)
        return best_loops(*asked)

    monkeypatch.setattr(lassos, "best_loops", noted)
    problem = next(p for p in map(energy_problem, range(99)) if _charges(p))
    search = BatterySearch(Search(problem.actions))
    first = solved(problem, search)
    assert first is not None and problem.energy is not None
    before = len(searched)
    full = len(problem.energy.percents) - 1
    solved(replace(problem, energy=replace(problem.energy, level=full)), search)
    assert len(searched) == before
    used = {action.name for action in (*first.prefix, *first.loop)}
    beside = next(a for a in problem.actions if a.name not in used and a.skill == "move")
    fewer = tuple(action for action in problem.actions if action is not beside)
    kept = solved(replace(problem, actions=fewer), search)
    assert kept is not None and kept.loop == first.loop and len(searched) == before
    dearer = tuple(
        replace(action, drain=action.drain + 1) if action.name == first.loop[-1].name else action
        for action in problem.actions
    )
    solved(replace(problem, actions=dearer), search)
    assert len(searched) > before


def _charges(problem: Problem) -> bool:
    found = next(BatterySearch(Search(problem.actions)).solutions(problem, BEFORE_FLIGHT), None)
    return found is not None and any(action.charger for action in found.loop)
