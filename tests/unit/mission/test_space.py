"""Where a mission takes place: without a map, without a fence, with walls of any shape."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any

import pytest
from moves import MOVE

from companion import NoPlanError, Planner, load_mission, simulate
from companion.drawn_maps import MAX_OPEN_CELLS, RIM_M
from companion.errors import MissionError
from companion.flight_events.skills import RouteBlocked
from companion.flight_events.sortie import ReturnedAsAsked, SetpointRefused
from companion.flights.simulated_world import world_alone, world_of
from companion.geometry import is_in_polygon
from companion.mission.model import Mission
from companion.motion.region import Area, Disc

FENCE = [[-2, -2], [14, -2], [14, 8], [-2, 8]]
FIELD: dict[str, Any] = {
    "version": 1,
    "name": "field",
    "limits": {"speed_mps": 2, "up_m": [0.5, 4], "fence": FENCE},
    "places": {
        "Home": {"east_m": 0, "north_m": 0, "up_m": 2},
        "A": {"east_m": 12, "north_m": 0, "up_m": 2},
    },
    "sets": {"Place": ["Home", "A"]},
    "skills": {"move": MOVE},
    "initially": ["at(Home)"],
    "task": {"see": "F at(A)"},
}
LIMITS = {"speed_mps": 2, "up_m": [0.5, 4]}
TRIANGLE = {"corners": [[5, -1], [8, -1], [6.5, 3]]}


def field(**changes: Any) -> Mission:
    return load_mission({**FIELD, **changes})


def refused(**changes: Any) -> MissionError:
    with pytest.raises(MissionError) as caught:
        field(**changes)
    return caught.value


# -- neither map nor walls -------------------------------------------------------------------------


def test_without_a_map_the_fence_holds_an_open_field() -> None:
    grid = field().grid
    assert not grid.occupied.any()
    assert grid.is_open
    assert grid.cell_m == 0.1
    (south, west), _, (north, east), _ = grid.corners
    assert (west, south) == (-2 - RIM_M, -2 - RIM_M)
    assert (east, north) == pytest.approx((14 + RIM_M, 8 + RIM_M), abs=0.1)
    assert grid.clearance_m((0.0, 0.0)) == grid.clearance_m((999.0, 0.0)) == float("inf")


@pytest.mark.parametrize(
    ("side_m", "cell_m"), [(30, 0.1), (80, 0.2), (200, 0.5), (480, 1.0), (2000, 5.0), (9000, 20.0)]
)
def test_a_large_field_has_larger_cells(side_m: float, cell_m: float) -> None:
    fence = [[-1, -1], [side_m, -1], [side_m, side_m], [-1, side_m]]
    home = {"east_m": 2 * cell_m, "north_m": 2 * cell_m, "up_m": 2}
    limits = {**LIMITS, "fence": fence, "unusual": True}
    places = {"Home": home, "A": {**home, "east_m": side_m / 2}}
    grid = field(limits=limits, places=places).grid
    assert grid.cell_m == cell_m
    assert grid.occupied.size <= MAX_OPEN_CELLS


def test_the_author_may_choose_the_cells() -> None:
    assert field(map={"cell_m": 0.5}).grid.cell_m == 0.5
    fence = [[0, 0], [9000, 0], [9000, 9000], [0, 9000]]
    limits = {**LIMITS, "fence": fence, "unusual": True}
    assert "cells are too many" in str(refused(limits=limits, map={"cell_m": 0.1}))


def test_without_a_fence_the_map_is_the_fence() -> None:
    area = {"east_m": [-2, 14], "north_m": [-2, 8]}
    mission = field(limits=LIMITS, map=area)
    assert set(mission.limits.fence) == {(-2, -2), (-2, 14), (8, 14), (8, -2)}
    assert not mission.grid.is_open


@pytest.mark.parametrize("map_", [{}, {"map": {"walls": [TRIANGLE]}}])
def test_without_both_nobody_knows_where_to_fly(map_: dict[str, Any]) -> None:
    error = refused(limits=LIMITS, **map_)
    assert error.what.startswith("the mission has neither a map nor a fence")
    assert "fence: [[east, north], ...] in limits is enough" in error.hint


@pytest.mark.parametrize(
    ("fence", "what"),
    [
        ([[0, 0], [9, 0], [0, 9], [9, 9]], "the fence is not a polygon: its edges from corner 2"),
        ([[0, 0], [9, 9], [3, 3]], "the fence is not a polygon: it has no area"),
        ([[0, 0], [9, 9], [9, 9], [0, 0]], "the fence is not a polygon: it has 2 corners"),
    ],
)
def test_a_fence_is_a_polygon(fence: list[list[float]], what: str) -> None:
    error = refused(limits={**LIMITS, "fence": fence})
    assert error.what.startswith(what)
    assert str(error.where) == "limits.fence"


# -- walls -----------------------------------------------------------------------------------------


def test_a_wall_may_be_a_polygon() -> None:
    grid = field(map={"walls": [TRIANGLE]}).grid
    assert grid.occupied[grid.cell((0.0, 6.5))]
    assert not grid.occupied[grid.cell((2.9, 5.5))]
    assert grid.occupied.sum() * 0.01 == pytest.approx(6.0, rel=0.15)  # of 3 m times 4 m


@pytest.mark.parametrize(
    ("wall", "what"),
    [
        ({}, "a wall of the map is neither a box nor a polygon"),
        ({"east_m": [0, 1]}, "a wall of the map is neither a box nor a polygon"),
        ({"east_m": [0, 1], **TRIANGLE}, "a wall of the map is neither a box nor a polygon"),
        ({"corners": [[0, 0], [1, 1]]}, "a wall of the map is not a polygon: it has 2 corners"),
    ],
)
def test_a_wall_that_is_none(wall: dict[str, Any], what: str) -> None:
    error = refused(map={"walls": [wall]})
    assert error.what.startswith(what)
    assert str(error.where) == "map"


# -- the simulator ---------------------------------------------------------------------------------


def test_the_world_of_a_mission_alone_is_its_own_map() -> None:
    mission = field(map={"walls": [TRIANGLE]})
    in_memory = world_of(mission)[1]
    of_file = world_of(mission, json.dumps(world_alone(mission)) + "\n")[1]
    assert in_memory is mission.grid
    assert of_file is not None
    assert of_file.is_open
    assert of_file.occupied.sum() == mission.grid.occupied.sum()
    for point in ((0.0, 0.0), (2.0, 6.0), (7.0, 7.0), (50.0, 50.0)):
        assert of_file.clearance_m(point) == pytest.approx(mission.grid.clearance_m(point))


def test_the_world_of_a_mission_alone_begins_where_the_mission_does() -> None:
    mission = field(initially=["at(A)"])
    assert world_of(mission)[0].start[:2] == (0.0, 12.0)


def test_a_field_without_walls_is_a_world_without_walls() -> None:
    scenario, grid = world_of(field(), json.dumps(world_alone(field())) + "\n")
    assert scenario.lidar is None  # there is nothing to see
    assert grid is not None  # the mission's own, as for any text


@pytest.mark.flight
@pytest.mark.parametrize(
    "map_", [pytest.param({}, marks=pytest.mark.long), {"map": {"walls": [TRIANGLE]}}]
)
def test_a_mission_without_a_map_flies(map_: dict[str, Any]) -> None:
    """Its lidar sees the wall that is told; off the map is no wall."""
    run = simulate(field(**map_))
    assert run.exit_code == 0
    assert run.collisions == 0


# -- keep-out zones and regions --------------------------------------------------------------------

POND = [[4, -1], [8, -1], [8, 3], [4, 3]]


def kept_out(**zones: Any) -> dict[str, Any]:
    return {"limits": {**FIELD["limits"], "keep_out": zones}}


def with_area(*corners: Sequence[float], **entry: Any) -> dict[str, Any]:
    place = {"east_m": 12, "north_m": 0, "up_m": 2, "corners": [*corners], **entry}
    return {"places": {**FIELD["places"], "A": place}}


@pytest.mark.parametrize(
    ("zone", "what"),
    [
        ([[4, 0], [8, 0]], "the keep-out zone pond is not a polygon: it has 2 corners"),
        ([[4, 0], [8, 2], [8, 0], [4, 2]], "the keep-out zone pond is not a polygon: its edges"),
        ([[40, 0], [48, 0], [48, 2]], "the keep-out zone pond lies outside the fence"),
        (
            [[4 + i / 2000, i % 2] for i in range(251)],
            "the keep-out zone pond is not a polygon: it h",
        ),
    ],
)
def test_a_zone_that_is_none(zone: list[list[float]], what: str) -> None:
    error = refused(**kept_out(pond=zone))
    assert error.what.startswith(what)
    assert str(error.where) == "limits.keep_out.pond"


def test_all_polygons_together_have_a_limit() -> None:
    ring = [[6 + math.cos(i / 21), 4 + math.sin(i / 21)] for i in range(130)]
    assert field(**kept_out(one=ring)).limits.keep_out["one"]
    error = refused(**kept_out(one=ring, other=ring))
    assert error.what == "the mission's polygons have 264 corners, at most 250 are allowed"


@pytest.mark.parametrize(
    ("zone", "what"),
    [
        ([[10, -1], [13, -1], [13, 1]], "place A is in the keep-out zone pond"),
        ([[10, -1], [11.5, -1], [11.5, 3]], "place A is only 0.50 m from the keep-out zone pond"),
    ],
)
def test_no_place_lies_in_a_zone_or_too_near(zone: list[list[float]], what: str) -> None:
    error = refused(**kept_out(pond=zone))
    assert error.what == what + ("" if "is in" in what else ", 0.6 m are needed")
    assert error.hint == "move it, or change limits.keep_out.pond"


def test_the_way_around_a_zone_costs_what_it_is_longer() -> None:
    around, straight = (Planner(field(**changes)) for changes in (kept_out(pond=POND), {}))
    costs = [planner.plan().lasso.prefix[0].cost_ms for planner in (around, straight)]
    assert costs[0] > costs[1]
    enclosed = kept_out(west=[[3, -2], [4, -2], [4, 8], [3, 8]])
    with pytest.raises(NoPlanError):
        Planner(field(**enclosed)).plan()


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        (with_area([3, 3], [5, 3], [5, 5]), "place A lies outside its own corners"),
        (with_area([11, 1], [13, 1]), "the region of A is not a polygon: it has 2 corners"),
        (with_area([9, -1], [13, -1], [13, 1], radius_m=1), "place A has both radius_m and corn"),
    ],
)
def test_a_region_that_is_none(changes: dict[str, Any], what: str) -> None:
    error = refused(**changes)
    assert error.what.startswith(what)
    assert str(error.where) == "places.A.corners"


def test_a_region_may_be_a_polygon() -> None:
    corners = [9, -1], [13, -1], [13, 1.5], [9, 1.5]
    place = field(**with_area(*corners)).places["A"]
    assert place.region == Area(((-1, 9), (-1, 13), (1.5, 13), (1.5, 9)))
    assert place.inner_m == 1.0
    assert field().places["A"].region == Disc(0.6)


@pytest.mark.flight
def test_a_flight_keeps_out_also_when_it_is_blown_and_called_home() -> None:
    """A gust drives the vehicle towards the pond; the operator calls it home meanwhile."""
    mission = field(**kept_out(pond=POND), task={"see": "G F at(A) & G F at(Home)"})
    world = {
        "version": 1,
        "happens": [
            {"at_s": 20, "wind": {"north_mps": -4}},
            {"at_s": 40, "operator": "MAV_CMD_NAV_RETURN_TO_LAUNCH"},
        ],
    }
    run = simulate(mission, world)
    assert isinstance(run.events[-1].event, ReturnedAsAsked)
    zone = mission.limits.keep_out["pond"]
    assert len(run.trajectory.positions) > 100
    assert not any(is_in_polygon(tuple(at), zone) for at in run.trajectory.positions.tolist())
    assert not [e for e in run.events if isinstance(e.event, SetpointRefused)]


@pytest.mark.flight
@pytest.mark.parametrize("jump_m", [2.0, pytest.param(3.0, marks=pytest.mark.long)])
def test_a_vehicle_that_is_in_a_zone_is_held_by_the_autopilot(jump_m: float) -> None:
    """Its position jumps into the pond, as far as anybody knows: the zone is in its fence, too."""
    mission = field(**kept_out(pond=POND), task={"see": "F at(A) & F G at(Home)"})
    run = simulate(
        mission, {"version": 1, "happens": [{"at_s": 11.5, "estimate": {"north_m": jump_m}}]}
    )
    assert run.exit_code == 5
    assert "a failsafe of the autopilot has control" in run.events[-1].event.text


# -- heights ---------------------------------------------------------------------------------------

HEDGE = {"corners": [[5, -9], [6, -9], [6, 15], [5, 15]], "up_m": 1.5}
LOW_HOME = {"east_m": 0, "north_m": 0, "up_m": 1}


def over_hedge(up_m: float, hedge: dict[str, Any] = HEDGE, **changes: Any) -> Mission:
    places = {"Home": LOW_HOME, "A": {"east_m": 12, "north_m": 0, "up_m": up_m}}
    return field(map={"walls": [hedge]}, places=places, **changes)


def test_a_hedge_is_flown_over_where_the_band_has_room_above_it() -> None:
    """From places that are high enough, and by a climb on the spot from lower ones."""
    assert Planner(over_hedge(2.1)).plan()
    assert Planner(over_hedge(2.05)).plan()
    with pytest.raises(NoPlanError):
        Planner(over_hedge(4.0, {**HEDGE, "up_m": 3.5})).plan()


def test_a_place_may_lie_over_a_hedge() -> None:
    above = {"A": {"east_m": 5.5, "north_m": 0, "up_m": 2.1}, "Home": LOW_HOME}
    assert field(map={"walls": [HEDGE]}, places=above).places["A"]
    below = {"A": {"east_m": 5.5, "north_m": 0, "up_m": 2.0}, "Home": LOW_HOME}
    assert refused(map={"walls": [HEDGE]}, places=below).what.startswith("place A is in a wall")


def test_a_climb_costs_its_time() -> None:
    """3.4 m on the spot at 1 m/s: s / v + v / a + a / j."""
    places = {"Home": {**LOW_HOME, "up_m": 0.5}, "A": {**LOW_HOME, "up_m": 3.9}}
    limits = {"speed_mps": 4, "up_m": [0.5, 4], "fence": FENCE}
    plan = Planner(field(places=places, limits=limits, vehicle={"climb_mps": 1.0})).plan()
    assert plan.lasso.prefix[0].cost_ms == pytest.approx(1000 * (3.4 / 1 + 1 / 2 + 2 / 8), abs=60)


@pytest.mark.flight
def test_a_hedge_is_flown_over_both_ways() -> None:
    """From below it its lidar sees it, and from above it does not; it stays what it is."""
    mission = over_hedge(3.0, task={"see": "F at(A) & F (at(A) & F G at(Home))"})
    run = simulate(mission)
    assert run.exit_code == 0
    assert run.collisions == 0
    over = [-down for _, east, down in run.trajectory.positions.tolist() if 4.65 < east < 6.35]
    assert len(over) > 20
    assert min(over) > 1.5 + 0.35
    told = {type(each.event) for each in run.events}
    assert not told & {SetpointRefused, RouteBlocked}
