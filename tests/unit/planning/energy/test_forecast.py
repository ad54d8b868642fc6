"""What is told of the charge at positions to come is what the independent check reckons with."""

from __future__ import annotations

import pytest
from energy_problems import energy_problem

from companion.planning.builtin.search import Search
from companion.planning.effort import BEFORE_FLIGHT
from companion.planning.energy.forecast import charge_ahead
from companion.planning.energy.search import BatterySearch
from companion.planning.lasso import Lasso


@pytest.mark.parametrize("seed", range(24))
def test_a_plan_that_lasts_has_at_each_position_what_is_required(seed: int) -> None:
    asked = energy_problem(seed)
    assert asked.energy is not None
    for found in BatterySearch(Search(asked.actions)).solutions(asked, BEFORE_FLIGHT):
        lasso = found.lasso
        told = charge_ahead(asked.energy, 1, asked.facts, lasso)
        flown = lasso.prefix if lasso.ends_at_rest else (*lasso.prefix, *lasso.loop)
        assert [each.action for each in told.ahead] == [action.name for action in flown]
        assert [each.duration_s for each in told.ahead] == [a.cost_ms / 1000 for a in flown]
        assert told.percent >= told.required_percent
        assert all(each.percent >= each.required_percent for each in told.ahead)
        assert told.reserve_percent == round(asked.energy.percents[1], 1)


@pytest.mark.parametrize("seed", range(24))
def test_the_next_lap_requires_what_was_told_of_its_beginning(seed: int) -> None:
    asked = energy_problem(seed)
    assert asked.energy is not None
    for found in BatterySearch(Search(asked.actions)).solutions(asked, BEFORE_FLIGHT):
        lasso, facts = found.lasso, asked.facts
        if lasso.ends_at_rest:
            continue
        for action in (*lasso.prefix, *lasso.loop):
            facts = action.apply(facts)
        told = charge_ahead(asked.energy, 1, asked.facts, lasso)
        lap = charge_ahead(asked.energy, 1, facts, Lasso((), lasso.loop))
        assert told.ahead[-1].required_percent == lap.required_percent
