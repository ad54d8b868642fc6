"""Routes on a map that changes, and on one whose ways are found in parts."""

from __future__ import annotations

import math

import numpy as np
import pytest
from drawn_rooms import EMPTY, ROOM, WIDE, at, grid_of

from companion.geometry import NorthEast
from companion.motion.clearance_level import ClearanceLevel
from companion.motion.free_space import FreeSpace
from companion.motion.grid import OccupancyGrid
from companion.motion.routes import RouteMap
from companion.slices import InSlices


def test_routes_are_those_of_a_map_made_anew() -> None:
    """In the room a door opens and another one closes: nothing of the old map is left."""
    places = {"B": at(1.5, 8.5)}
    left, right = (
        grid_of("##########", row, "#........#", "####.#####", "#........#", "##########")
        for row in ("#...#....#", "#........#")
    )
    routes = RouteMap(left, places, WIDE, 0.0)
    for grid in (right, ROOM, left):
        routes.see(grid)
        fresh = RouteMap(grid, places, WIDE, 0.0)
        for start in ((1.5, 1.5), (4.5, 8.5), (4.5, 1.5)):
            assert routes.distance_m(start, "B") == fresh.distance_m(start, "B")
            assert routes.is_free(start) == fresh.is_free(start)
            route, expected = routes.route((*start, -1.0), "B"), fresh.route((*start, -1.0), "B")
            assert (route is None) == (expected is None)
            if route is not None and expected is not None:
                assert route.waypoints.tolist() == expected.waypoints.tolist()


def test_paths_are_found_in_parts_until_all_are_known() -> None:
    """At least one in each part, however small."""
    places = {name: at(3.5, 0.5 + i) for i, name in enumerate("ABCD", start=2)}
    routes = RouteMap(grid_of(*["." * 10] * 8), places, WIDE, 0.0)
    assert not routes.find(0)
    assert [routes.find(1) for _ in range(5)] == [False, False, False, True, True]
    routes.see(grid_of(*["." * 10] * 7, "." * 9 + "#"))
    assert not routes.find(0)
    assert routes.find(10**6) and routes.find(0)


HALL = np.zeros((120, 160), dtype=np.bool_)
HALL[:90, 40] = HALL[30:, 80] = HALL[:90, 120] = True  # three walls with a gap each
HALL_PLACES = {"A": at(1.05, 1.05), "B": at(6.05, 6.05), "C": at(11.05, 15.05)}


def hall_routes() -> RouteMap:
    return RouteMap(OccupancyGrid(HALL, 0.1, (0.0, 0.0)), HALL_PLACES, WIDE, 0.3)


@pytest.mark.parametrize("start", [(1.05, 1.05), (8.0, 2.0)])
def test_a_question_that_is_put_aside_is_answered_although_the_map_changes_meanwhile(
    start: NorthEast,
) -> None:
    before = hall_routes().distance_m(start, "C")
    other = HALL.copy()
    other[60:, 120] = True
    routes = hall_routes()
    asking = InSlices(lambda: routes.distance_m(start, "C"), slice_us=1)
    while not asking.step():
        routes.see(OccupancyGrid(other, 0.1, (0.0, 0.0)))
    assert asking.result == before


@pytest.mark.parametrize(
    "start",
    [
        (1.05, 1.05),
        pytest.param((2.0, 6.0), marks=pytest.mark.long),
        pytest.param((11.0, 15.0), marks=pytest.mark.long),
        pytest.param((0.1, 5.0), marks=pytest.mark.long),
        (6.0, 8.32),
    ],
)
@pytest.mark.parametrize("place", HALL_PLACES)
def test_after_a_search_in_parts_a_route_is_known(
    start: NorthEast, place: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is that of a whole search, also from a start that stands near a wall."""
    routes, whole = hall_routes(), hall_routes()
    whole.find(10**9)
    parts = 0
    while not routes.search(start, place, 500):
        parts += 1
    assert parts < 60

    def nothing(*_: object) -> None:
        raise AssertionError("nothing is searched any more")

    monkeypatch.setattr("companion.motion.distance_maps.continued", nothing)
    assert routes.distance_m(start, place) == pytest.approx(whole.distance_m(start, place))
    found, expected = (each.route((*start, -1.0), place) for each in (routes, whole))
    assert found is not None and expected is not None
    assert found.waypoints.tolist() == expected.waypoints.tolist()


def test_a_near_place_takes_few_parts() -> None:
    """Three metres through an open room, and the way to the other end of the hall."""
    near, far = (
        next(i for i in range(99) if routes.search(start, "A", 500))
        for routes, start in ((hall_routes(), (3.05, 3.05)), (hall_routes(), (11.05, 15.05)))
    )
    assert near < 4 < 15 < far


def test_what_is_cut_off_takes_no_search() -> None:
    occupied = HALL.copy()
    occupied[:, 100] = True
    routes = RouteMap(OccupancyGrid(occupied, 0.1, (0.0, 0.0)), HALL_PLACES, WIDE, 0.3)
    assert routes.search((1.05, 1.05), "C", 0)
    assert routes.distance_m((1.05, 1.05), "C") == math.inf
    assert not routes.search((1.05, 1.05), "B", 0)


def test_the_quick_look_for_an_entry_finds_what_the_thorough_one_does(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    chance = np.random.default_rng(0)
    starts = [(n, e) for n, e in chance.uniform((0.0, 0.0), (12.0, 16.0), (60, 2)).tolist()]
    starts += [(n + 0.5, e) for n, e in ((1.05, 1.05), (6.05, 6.05))]  # beside a region
    quick, thorough = hall_routes(), hall_routes()
    found = [quick.distance_m(start, place) for start in starts for place in HALL_PLACES]
    monkeypatch.setattr(ClearanceLevel, "plain_entry", lambda *_: None)
    assert found == [thorough.distance_m(s, place) for s in starts for place in HALL_PLACES]


def test_a_place_that_was_covered_has_its_paths_again() -> None:
    empty, covered = grid_of("......", "......"), grid_of("....##", "....##")
    routes = RouteMap(empty, {"B": at(1.0, 5.5)}, WIDE, 0.0)
    before = routes.distance_m((0.5, 0.5), "B")
    routes.see(covered)
    assert routes.distance_m((0.5, 0.5), "B") == math.inf
    routes.see(empty)
    assert routes.distance_m((0.5, 0.5), "B") == before < math.inf


def test_levels_that_no_route_needs_cost_nothing_when_the_map_changes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    routes, made = hall_routes(), list[float]()
    routes.add_clearance(1.0)
    assert routes.route((1.05, 1.05, -2.0), "C") is not None
    counted = ClearanceLevel._free_space

    def counting(level: ClearanceLevel) -> FreeSpace:
        made.append(level.clearance_m)
        return counted(level)

    monkeypatch.setattr(ClearanceLevel, "_free_space", counting)
    other = HALL.copy()
    other[110, 10] = True
    routes.see(OccupancyGrid(other, 0.1, (0.0, 0.0)))
    assert sorted(made) == pytest.approx([0.3, 1.0, 1.3])  # least, enough, and all


def test_the_version_changes_with_the_free_cells_alone() -> None:
    routes = RouteMap(EMPTY, {}, WIDE, 0.5)
    before = routes.version
    occupied = EMPTY.occupied.copy()
    occupied[0, 0] = True  # all that is near to it is near to the outer walls too
    routes.see(OccupancyGrid(occupied, 0.1, (0.0, 0.0)))
    assert routes.version == before
    occupied[20, 20] = True
    routes.see(OccupancyGrid(occupied, 0.1, (0.0, 0.0)))
    assert routes.version != before
