"""What random flights say of themselves is true: a good end is one by the audit, too."""

from __future__ import annotations

import pytest
from random_flights import random_flight

from companion.campaigns.measuring import fly
from companion.campaigns.outcomes import RowOutcome
from companion.campaigns.rows import Row
from companion.flights.simulated_world import world_of
from companion.mission.loader import load_mission

LIMIT_S = 240.0
FEW, MANY = (1,), 300


@pytest.mark.parametrize(
    "seed", [pytest.param(i, marks=[] if i in FEW else [pytest.mark.long]) for i in range(MANY)]
)
def test_a_flight_ends_as_it_says(seed: int) -> None:
    given, world = random_flight(seed)
    mission = load_mission(given)
    flown = fly(mission, world_of(mission, world), Row(0, seed), LIMIT_S)
    assert flown.outcome not in (RowOutcome.ERROR, RowOutcome.CRASH), flown.reason
    assert not flown.broken, flown.margins
    assert not (flown.exit_code == 0 and flown.outcome is RowOutcome.VIOLATED), flown.conjunct
    if flown.outcome is RowOutcome.NO_PLAN:
        assert flown.exit_code not in (0, None)
