"""open_field: no map, no scenario; a hedge is flown over, and a pond is never entered."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from companion import Mission, SimulationResult, load_mission, simulate
from companion.flight_events.skills import PlaceReached, RouteBlocked
from companion.flight_events.sortie import ReturnedAsAsked, SetpointRefused
from companion.geometry import is_in_polygon
from companion.motion.polygons import distance_to_edges

OPEN_FIELD = Path(__file__).parents[2] / "missions" / "open_field.yaml"


@pytest.fixture(scope="module")
def mission() -> Mission:
    return load_mission(OPEN_FIELD)


def check(mission: Mission, run: SimulationResult) -> None:
    """What holds at each moment of each flight."""
    zone = np.array(mission.limits.keep_out["pond"])
    hedge = next(wall for wall in mission.walls if wall.up_m is not None)
    points = run.trajectory.positions
    assert len(points) > 500
    assert run.collisions == 0
    assert not any(is_in_polygon(tuple(at), mission.limits.keep_out["pond"]) for at in points)
    assert distance_to_edges(points[:, :2], zone).min() > mission.vehicle.radius_m
    over = [-down for *at, down in points.tolist() if is_in_polygon(tuple(at), hedge.corners)]
    assert not over or min(over) > (hedge.up_m or 0.0) + mission.vehicle.radius_m
    assert -points[:, 2].min() < mission.limits.up_m[1]
    told = {type(each.event) for each in run.events}
    assert not told & {SetpointRefused, RouteBlocked}


@pytest.mark.slow
def test_the_story(mission: Mission) -> None:
    run = simulate(mission)
    assert run.exit_code == 0
    check(mission, run)
    reached = [e.event.place for e in run.events if isinstance(e.event, PlaceReached)]
    assert reached == ["Gate", "Mast", "Home"]


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize("at_s", [20, 42])
def test_a_return_home_respects_the_hedge_and_the_pond(mission: Mission, at_s: float) -> None:
    """Before the hedge, and on the way past the pond, in a wind that drives towards the pond."""
    happens: list[dict[str, Any]] = [
        {"at_s": 10, "wind": {"east_mps": -3, "north_mps": 2}},
        {"at_s": at_s, "operator": "MAV_CMD_NAV_RETURN_TO_LAUNCH"},
    ]
    run = simulate(mission, {"version": 1, "happens": happens}, seed=3)
    assert isinstance(run.events[-1].event, ReturnedAsAsked)
    check(mission, run)
