"""Places to land at without a plan lie on open ground, known from the beginning."""

from __future__ import annotations

from typing import Any

import pytest

from companion.errors import MissionError
from companion.mission.loader import load_mission
from companion.mission.otherwise import LandAtSafePlace
from companion.planning.notices import notices
from companion.planning.planner import Planner

WALL = {"east_m": [2, 10], "north_m": [-4, 4], "up_m": 3}


def data(place: dict[str, Any], land_at: list[str], **more: Any) -> dict[str, Any]:
    return {
        "version": 1,
        "name": "meadow",
        "map": {"walls": [WALL]},
        "limits": {"speed_mps": 2, "up_m": [1, 8], "fence": [[-5, -8], [14, -8], [14, 8], [-5, 8]]},
        "places": {
            "Home": {"east_m": 0, "north_m": -6, "up_m": 2},
            "P": {"east_m": 0, "north_m": 0, "up_m": 6} | place,
        },
        "skills": {"rest": {"effect": "rested", "execute": "wait(1)"}},
        "initially": ["at(Home)"],
        "goal": "rested",
        "otherwise": {"land_at": land_at},
    } | more


@pytest.mark.parametrize(
    "place",
    [{"east_m": 6}, {"east_m": 1.7}, {"east_m": 0.5, "radius_m": 1.5}],
    ids=["above it", "beside it", "with a part of its region beside it"],
)
def test_one_above_or_beside_a_low_wall_is_refused(place: dict[str, Any]) -> None:
    with pytest.raises(MissionError) as refused:
        load_mission(data(place, ["Home", "P"]))
    assert str(refused.value).splitlines() == [
        "otherwise.land_at[1]: P, to land at, lies above or beside a wall of 3 m",
        "    the autopilot lands without looking: write a place on open ground",
    ]


def test_a_place_that_is_not_landed_at_may_lie_there() -> None:
    assert load_mission(data({"east_m": 6}, ["Home"])).safe_places == ("Home",)


def test_one_that_is_found_in_flight_is_refused() -> None:
    found = {"when": "EVENT[there] > 0", "latch": True}
    place = {"found_by": "there", "radius_m": 3, "east_m": -1.5}
    with pytest.raises(MissionError, match="P is found in flight: until then nobody knows"):
        load_mission(data(place, ["P"], events={"there": found}))


def test_one_to_which_no_route_leads_is_noticed() -> None:
    """Walls divide the meadow, from the ground to the ceiling."""
    across = {"east_m": [-6, 15], "north_m": [-3, -2]}
    mission = load_mission(data({}, ["Home", "P"], map={"walls": [across]}))
    assert mission.otherwise == LandAtSafePlace(("Home", "P"))
    planner = Planner(mission)
    told = [str(notice) for notice in notices(planner, planner.plan())]
    assert "P: in land_at, and no clear route leads there from Home" in told
