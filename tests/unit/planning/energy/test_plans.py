"""Whole plans on a battery, against a search that looks at every level of charge."""

from __future__ import annotations

import pytest
from energy_problems import energy_problem
from problems import histories
from reference_energy import EnergyReference, flown

from companion.planning.builtin.search import Search
from companion.planning.check import fault
from companion.planning.effort import BEFORE_FLIGHT
from companion.planning.energy.search import energy_solutions
from companion.planning.energy_check import energy_fault

LAPS = 40
DEFAULT, ALL = 25, 240


@pytest.mark.parametrize(
    "seed",
    [*range(DEFAULT), *(pytest.param(s, marks=pytest.mark.long) for s in range(DEFAULT, ALL))],
)
def test_a_plan_is_found_if_there_is_one_and_no_lap_is_shorter(seed: int) -> None:
    asked = energy_problem(seed)
    best_ms = EnergyReference(asked).best_ms()
    found = list(energy_solutions(Search(asked.actions), asked, BEFORE_FLIGHT))
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
