"""How a row ends at the limit of its campaign: with what is so there."""

from __future__ import annotations

from functools import cache

import pytest
from varied import MISSION

from companion.campaigns.measuring import fly
from companion.campaigns.outcomes import FlownRow, RowOutcome
from companion.campaigns.rows import Row
from companion.flights.simulated_world import world_of
from companion.mission.loader import load_mission

CUT = 8.0
"""When the link is cut for good, in the air."""
LAND, HOLD = 4, 5
"""What PX4 does without setpoints, by `COM_OBL_RC_ACT`."""


@cache
def flown(limit_s: float, without_setpoints: int = HOLD, cut_at_s: float = CUT) -> FlownRow:
    """A row whose link is cut."""
    mission = load_mission(MISSION)
    world = {
        "version": 1,
        "parameters": {"COM_OBL_RC_ACT": without_setpoints},
        "happens": [{"at_s": cut_at_s, "link": {"port": "companion", "loss": 1}}],
    }
    return fly(mission, world_of(mission, world), Row(0, 1, {}), limit_s)


def test_a_vehicle_that_is_down_and_not_heard_has_aborted() -> None:
    row = flown(60.0, LAND)
    assert (row.outcome, row.exit_code) == (RowOutcome.ABORTED, 4)
    assert row.reason.startswith("no position from the vehicle for 5")


@pytest.mark.parametrize("limit_s", [6.0, pytest.param(30.0, marks=pytest.mark.long)])
def test_one_in_the_air_is_cut_off(limit_s: float) -> None:
    row = flown(limit_s)
    assert (row.outcome, row.exit_code) == (RowOutcome.LIMIT, None)
    assert row.reason == "cut off at the limit, in the air"


def test_one_that_has_not_armed_yet_is_told_so() -> None:
    assert flown(0.5).reason == "cut off at the limit, on the ground, not armed"
