"""In flight a loop on a battery is entered where what has waited longest is met soonest."""

from __future__ import annotations

from dataclasses import replace
from itertools import chain
from random import Random
from typing import Any

import pytest
from moves import MOVE

from companion.mission.loader import load_mission
from companion.planning.lasso import Lasso, Problem
from companion.planning.planner import Planner

SITES = ("A", "B", "C", "D", "E")


def patrol(seed: int) -> Planner:
    """Five sites and two docks of a large field, on a battery for about half of them."""
    chance = Random(seed)
    names = ["Home", *SITES, "W", "X"]

    def place() -> dict[str, float]:
        return {"east_m": chance.uniform(0, 300), "north_m": chance.uniform(0, 300), "up_m": 5}

    data: dict[str, Any] = {
        "version": 1,
        "name": "patrol",
        "limits": {
            "speed_mps": 5,
            "up_m": [1, 12],
            "fence": [[-9, -9], [309, -9], [309, 309], [-9, 309]],
        },
        "battery": {"reserve": 20, "capacity_wh": 25},
        "places": {name: place() for name in names},
        "sets": {"Place": names, "Pad": ["W", "X"]},
        "skills": {
            "move": MOVE,
            "recharge": {
                "parameters": {"pad": "Pad"},
                "precondition": "at(pad)",
                "effect": "at(pad)",
                "charge_rate": [[0, 1], [80, 1], [100, 0.1]],
                "execute": ["land()", "charge(auto)", "take_off()"],
            },
        },
        "initially": ["at(Home)"],
        "task": {"patrol": f"patrolling({', '.join(SITES)})"},
    }
    return Planner(load_mission(data))


def worst_age_ms(problem: Problem, lasso: Lasso) -> int:
    """The greatest age of a conjunct, when the plan meets it first."""
    met: dict[int, int] = {}
    now_ms = 0
    for action in chain(lasso.prefix, lasso.loop, lasso.loop):
        now_ms += action.cost_ms
        for number, conjunct in enumerate(problem.conjuncts):
            if conjunct.facts & action.adds:
                met.setdefault(number, now_ms)
    return max(met[n] - since for n, since in enumerate(problem.waiting_since_ms))


@pytest.mark.parametrize(
    "seed", [*range(2), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(2, 5))]
)
def test_what_has_waited_longest_is_met_soonest(seed: int) -> None:
    planner, chance = patrol(seed), Random(seed)
    quickest_first = 0
    for _ in range(6):
        asked, read = planner.initial_problem(at=chance.choice(list(planner.mission.places)))
        assert asked.energy is not None
        full = len(asked.energy.percents) - 1
        level = chance.randint(full // 2, full)
        asked = replace(asked, energy=replace(asked.energy, level=level))
        since_ms = tuple(chance.randint(0, 400_000) for _ in asked.conjuncts)
        waits = replace(asked, waiting_since_ms=since_ms)
        quickest, fair = planner.solver.replan(asked, read), planner.solver.replan(waits, read)
        if quickest is None or fair is None:
            assert quickest is fair is None
            continue
        assert fair.lap_cost_ms == quickest.lap_cost_ms
        assert worst_age_ms(waits, fair) <= worst_age_ms(waits, quickest)
        assert fair.prefix_cost_ms >= quickest.prefix_cost_ms
        quickest_first += fair.loop != quickest.loop
    assert seed or quickest_first
