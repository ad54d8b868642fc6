"""Routes on small maps: where they begin and end, and what makes them impossible."""

from __future__ import annotations

import math

import numpy as np
import pytest

from companion.geometry import NorthEast, is_in_polygon
from companion.motion.clearance_level import ClearanceLevel
from companion.motion.free_space import FreeSpace
from companion.motion.grid import OccupancyGrid, cells_inside
from companion.motion.path import Path
from companion.motion.region import Disc
from companion.motion.routes import PlaceRegion, Route, RouteMap
from companion.slices import InSlices

WIDE: list[NorthEast] = [(-9, -9), (-9, 99), (99, 99), (99, -9)]


def grid_of(*rows: str, cell_m: float = 1.0) -> OccupancyGrid:
    """A grid from a drawing, its last line southmost; # is occupied."""
    occupied = np.array([[cell == "#" for cell in row] for row in reversed(rows)])
    return OccupancyGrid(occupied, cell_m, (0.0, 0.0))


def at(
    north_m: float, east_m: float, radius_m: float = 0.4, is_exclusive: bool = True
) -> PlaceRegion:
    return PlaceRegion((north_m, east_m, -2.0), Disc(radius_m), is_exclusive)


def route_of(routes: RouteMap, start: NorthEast, name: str) -> Route:
    route = routes.route((*start, -1.0), name)
    assert route is not None
    return route


def distance_to_route(route: Route, point: NorthEast) -> float:
    """Least distance of a point to the legs of a route, in the plane."""
    a, b = route.waypoints[:-1, :2], route.waypoints[1:, :2]
    leg = b - a
    share = np.sum((point - a) * leg, axis=1) / np.maximum(np.sum(leg * leg, axis=1), 1e-12)
    return float(np.linalg.norm(a + np.clip(share, 0, 1)[:, None] * leg - point, axis=1).min())


ROOM = grid_of(
    "##########",
    "#........#",
    "#...##...#",
    "#...##...#",
    "#........#",
    "##########",
)


def test_a_route_begins_at_the_start_and_ends_at_the_place_exactly() -> None:
    routes = RouteMap(ROOM, {"B": at(4.3, 8.1)}, WIDE, 0.0)
    waypoints = route_of(routes, (1.2, 1.3), "B").waypoints
    assert waypoints[0].tolist() == [1.2, 1.3, -1.0]
    assert waypoints[-1].tolist() == [4.3, 8.1, -2.0]


def test_a_free_line_of_sight_is_one_leg_of_its_own_length() -> None:
    routes = RouteMap(ROOM, {"B": at(1.4, 8.6)}, WIDE, 0.0)
    route = route_of(routes, (1.5, 1.5), "B")
    assert len(route.waypoints) == 2
    assert route.length_m == pytest.approx(math.dist((1.5, 1.5, -1.0), (1.4, 8.6, -2.0)))


def test_the_altitude_changes_evenly_along_the_way() -> None:
    routes = RouteMap(ROOM, {"B": at(3.5, 7.0)}, WIDE, 0.0)
    waypoints = route_of(routes, (2.5, 1.5), "B").waypoints
    along = np.cumsum(np.linalg.norm(np.diff(waypoints[:, :2], axis=0), axis=1))
    assert len(waypoints) > 2
    assert waypoints[1:, 2] == pytest.approx(-1.0 - along / along[-1], abs=1e-3)


def test_straight_up_is_a_route() -> None:
    routes = RouteMap(ROOM, {"B": at(1.5, 1.5)}, WIDE, 0.0)
    route = route_of(routes, (1.5, 1.5), "B")
    assert route.length_m == pytest.approx(1.0)
    assert routes.distance_m((1.5, 1.5), "B") == 0.0


def test_a_place_behind_a_wall_has_no_route() -> None:
    walled = grid_of("...#...", "...#...")
    routes = RouteMap(walled, {"B": at(1.0, 6.0)}, WIDE, 0.0)
    assert routes.route((1.0, 1.0, -1.0), "B") is None
    assert routes.distance_m((1.0, 1.0), "B") == math.inf


@pytest.mark.parametrize("place", [at(1.5, 4.5), at(2.5, 4.5), at(50.0, 50.0)])
def test_a_place_too_close_to_an_obstacle_or_off_the_map_has_no_route(place: PlaceRegion) -> None:
    routes = RouteMap(ROOM, {"B": place}, WIDE, 0.5)
    assert routes.route((1.5, 1.5, -1.0), "B") is None


def test_an_unknown_place_is_a_mistake_of_the_caller() -> None:
    with pytest.raises(KeyError):
        RouteMap(ROOM, {}, WIDE, 0.0).distance_m((1.5, 1.5), "B")


def test_a_start_inside_the_clearance_band_leaves_it_by_the_shortest_way() -> None:
    empty = OccupancyGrid(np.zeros((40, 80), dtype=np.bool_), 0.1, (0.0, 0.0))
    routes = RouteMap(empty, {"B": at(2.0, 6.0)}, WIDE, 0.5)
    assert not routes.is_free((0.35, 2.0))
    waypoints = route_of(routes, (0.35, 2.0), "B").waypoints
    assert waypoints[0].tolist() == [0.35, 2.0, -1.0]
    assert waypoints[1, :2] == pytest.approx([0.55, 2.05])  # the nearest free cell's centre


def test_a_start_far_from_free_cells_has_no_route() -> None:
    empty = OccupancyGrid(np.zeros((80, 80), dtype=np.bool_), 0.1, (0.0, 0.0))
    routes = RouteMap(empty, {"B": at(4.0, 4.0)}, WIDE, 1.9)
    assert routes.route((0.5, 4.0, -1.0), "B") is None
    assert routes.route((-50.0, 4.0, -1.0), "B") is None


def test_the_way_out_of_the_band_does_not_pass_a_thin_wall() -> None:
    occupied = np.zeros((40, 41), dtype=np.bool_)
    occupied[:, 8] = True  # a strip of 0.8 m, too narrow to be free, west of a thin wall
    routes = RouteMap(OccupancyGrid(occupied, 0.1, (0.0, 0.0)), {"B": at(2, 3)}, WIDE, 0.4)
    assert routes.route((2.0, 0.75, -1.0), "B") is None
    assert routes.route((2.0, 0.95, -1.0), "B") is not None


def test_a_start_on_the_edge_of_a_free_cell_has_a_route() -> None:
    empty = OccupancyGrid(np.zeros((40, 80), dtype=np.bool_), 0.1, (0.0, 0.0))
    routes = RouteMap(empty, {"B": at(2.0, 6.0)}, WIDE, 0.45)
    assert routes.is_free((0.55, 2.0)) and not routes.is_free((0.45, 2.0))
    for start in [(0.5, 2.0), (0.5, 2.05), (0.5, 0.5)]:
        assert routes.route((*start, -1.0), "B") is not None


def test_the_fence_agrees_with_the_polygon_rule() -> None:
    """A cell is free if its corners are inside, and no edge crosses it, as one of a notch does."""
    fence: list[NorthEast] = [(0.7, 0.4), (5.3, 2.2), (4.6, 9.1), (2.5, 4.4), (0.2, 8.8)]
    empty = OccupancyGrid(np.zeros((6, 10), dtype=np.bool_), 1.0, (0.0, 0.0))
    routes = RouteMap(empty, {}, fence, 0.0)
    edges = np.linspace(fence, [*fence[1:], fence[0]], 1000)
    for row, col in np.ndindex(6, 10):
        corners = [(row + r, col + c) for r in (0, 1) for c in (0, 1)]
        expected = all(is_in_polygon(corner, fence) for corner in corners)
        expected &= not np.any(np.all((edges > (row, col)) & (edges < (row + 1, col + 1)), axis=-1))
        assert routes.is_free((row + 0.5, col + 0.5)) is expected
    assert not routes.is_free((-1.0, 2.0))


def test_routes_keep_a_margin_to_the_fence() -> None:
    """A cell is inside if none of its corners is nearer to an edge of the fence."""
    fence: list[NorthEast] = [(0.7, 0.4), (5.3, 2.2), (4.6, 9.1), (2.5, 4.4), (0.2, 8.8)]
    edges = list(zip(fence, [*fence[1:], fence[0]], strict=True))
    empty = OccupancyGrid(np.zeros((24, 40), dtype=np.bool_), 0.25, (0.0, 0.0))
    inside, within = cells_inside(empty, fence), cells_inside(empty, fence, 0.3)
    assert not (within & ~inside).any() and inside.sum() > within.sum() > 0
    for row, col in np.argwhere(inside):
        corners = [(0.25 * (row + r), 0.25 * (col + c)) for r in (0, 1) for c in (0, 1)]
        gap_m = min(dense_distance(corner, edge) for corner in corners for edge in edges)
        if abs(gap_m - 0.3) > 1e-3:
            assert within[row, col] == (gap_m > 0.3), (row, col)


def dense_distance(point: NorthEast, edge: tuple[NorthEast, NorthEast]) -> float:
    """To the nearest of a thousand points of the edge."""
    shares = np.linspace(0.0, 1.0, 1001)[:, None]
    along = (1 - shares) * np.array(edge[0]) + shares * np.array(edge[1])
    return float(np.hypot(*(along - np.array(point)).T).min())


def test_a_route_goes_around_the_region_of_another_place() -> None:
    empty = OccupancyGrid(np.zeros((60, 100), dtype=np.bool_), 0.1, (0.0, 0.0))
    places = {"B": at(3.0, 9.0), "X": at(3.0, 5.0, radius_m=1.0)}
    route = route_of(RouteMap(empty, places, WIDE, 0.2), (3.0, 1.0), "B")
    assert distance_to_route(route, (3.0, 5.0)) >= 1.0 - 1e-9
    shortest = 2 * (math.sqrt(16 - 1) + math.asin(1 / 4))  # two tangents and the arc between
    flown_m = Path(route).length_m
    assert shortest < math.sqrt(flown_m**2 - 1.0) < 1.01 * shortest  # it sinks by 1 m


def test_a_place_that_the_task_does_not_mention_may_be_crossed() -> None:
    empty = OccupancyGrid(np.zeros((60, 100), dtype=np.bool_), 0.1, (0.0, 0.0))
    places = {"B": at(3.0, 9.0), "X": at(3.0, 5.0, radius_m=1.0, is_exclusive=False)}
    assert len(route_of(RouteMap(empty, places, WIDE, 0.2), (3.0, 1.0), "B").waypoints) == 2


def test_a_vehicle_leaves_the_region_it_is_in_and_does_not_come_back() -> None:
    corridor = OccupancyGrid(np.zeros((12, 100), dtype=np.bool_), 0.1, (0.0, 0.0))
    places = {"W": at(0.6, 1.0), "E": at(0.6, 9.0), "X": at(0.6, 5.0, radius_m=0.8)}
    routes = RouteMap(corridor, places, WIDE, 0.2)  # X closes the corridor
    assert routes.route((0.6, 5.0, -1.0), "E") is not None
    assert routes.route((0.6, 5.7, -1.0), "W") is not None
    assert routes.route((0.6, 1.0, -1.0), "X") is not None
    assert routes.route((0.6, 1.0, -1.0), "E") is None
    assert routes.distance_m((0.6, 1.0), "E") == math.inf


def test_leaving_a_region_costs_no_detour() -> None:
    occupied = np.zeros((60, 100), dtype=np.bool_)
    occupied[20:60, 40:44] = True
    grid = OccupancyGrid(occupied, 0.1, (0.0, 0.0))
    lengths = [
        route_of(
            RouteMap(grid, {"B": at(5.0, 9.0), "X": at(4.8, 2.0, 2.5, leaving)}, WIDE, 0.0),
            (4.8, 2.0),
            "B",
        ).length_m
        for leaving in (True, False)
    ]
    assert lengths[0] == pytest.approx(lengths[1], abs=1e-3)


def test_a_place_inside_the_region_of_another_cannot_be_entered() -> None:
    empty = OccupancyGrid(np.zeros((60, 60), dtype=np.bool_), 0.1, (0.0, 0.0))
    places = {"B": at(3.0, 3.2), "X": at(3.0, 3.0, radius_m=1.0)}
    routes = RouteMap(empty, places, WIDE, 0.2)
    assert routes.route((1.0, 1.0, -1.0), "B") is None
    assert routes.route((3.0, 3.0, -1.0), "B") is not None


def test_a_route_from_motion_leads_to_where_the_vehicle_can_stop() -> None:
    routes = RouteMap(ROOM, {"A": at(4.5, 1.5)}, WIDE, 0.0)
    start, stop = (1.5, 1.5, -1.0), (1.5, 2.5, -1.0)
    route = routes.route_from_motion(start, stop, "A")
    onward = routes.route(stop, "A")
    assert route is not None and onward is not None
    assert route.waypoints[0] == pytest.approx(start)
    assert route.waypoints[1:] == pytest.approx(onward.waypoints)


@pytest.mark.parametrize(("north_m", "is_near"), [(0.45, True), (0.35, True), (0.25, False)])
def test_a_vehicle_may_run_out_a_cell_nearer_than_the_clearance(
    north_m: float, is_near: bool
) -> None:
    """It would do so in any case; a route that begins where it was would only leave it behind."""
    corridor = OccupancyGrid(np.zeros((12, 100), dtype=np.bool_), 0.1, (0.0, 0.0))
    routes = RouteMap(corridor, {"A": at(0.55, 9.0)}, WIDE, 0.4)
    route = routes.route_from_motion((0.45, 2.0, -1.0), (north_m, 4.0, -1.0), "A")
    assert (route is not None) == is_near


def test_a_vehicle_does_not_run_out_of_the_fence() -> None:
    fence: list[NorthEast] = [(-9, -9), (-9, 3.5), (99, 3.5), (99, -9)]
    room = OccupancyGrid(np.zeros((40, 100), dtype=np.bool_), 0.1, (0.0, 0.0))
    routes = RouteMap(room, {"A": at(2.0, 1.0)}, fence, 0.4)
    ends = [routes.route_from_motion((2.0, 2.0, -1.0), (2.0, e, -1.0), "A") for e in (3.3, 3.7)]
    assert [end is not None for end in ends] == [True, False]


@pytest.mark.parametrize("stop", [(2.5, 4.5, -1.0), (1.5, 20.0, -1.0)])
def test_a_route_does_not_begin_through_a_wall(stop: tuple[float, float, float]) -> None:
    routes = RouteMap(ROOM, {"A": at(4.5, 1.5)}, WIDE, 0.0)
    assert routes.route_from_motion((1.5, 1.5, -1.0), stop, "A") is None


# -- a map that changes ----------------------------------------------------------------------------


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


@pytest.mark.parametrize("start", [(1.05, 1.05), (2.0, 6.0), (11.0, 15.0), (0.1, 5.0), (6.0, 8.32)])
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


EMPTY = OccupancyGrid(np.zeros((80, 80), dtype=np.bool_), 0.1, (0.0, 0.0))


def test_levels_that_no_route_needs_cost_nothing_when_the_map_changes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    routes, made = hall_routes(), list[float]()
    routes.add_clearance(1.0)
    assert routes.route((1.05, 1.05, -2.0), "C") is not None
    counted = ClearanceLevel._free_space

    def counting(level: ClearanceLevel) -> FreeSpace:
        made.append(level._clearance_m)
        return counted(level)

    monkeypatch.setattr(ClearanceLevel, "_free_space", counting)
    other = HALL.copy()
    other[110, 10] = True
    routes.see(OccupancyGrid(other, 0.1, (0.0, 0.0)))
    assert sorted(made) == pytest.approx([0.3, 1.3])


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


def with_crate() -> RouteMap:
    """A crate of 1 m x 1 m in the middle of 8 m x 8 m, and 0.6 m around it."""
    occupied = np.zeros((80, 80), dtype=np.bool_)
    occupied[35:45, 35:45] = True
    routes = RouteMap(EMPTY, {}, WIDE, 0.5)
    routes.see(OccupancyGrid(occupied, 0.1, (0.0, 0.0)))
    return routes


@pytest.mark.parametrize(
    ("path", "is_clear"),
    [
        ([(1, 4, -2), (2.5, 4, -2)], True),
        ([(1, 4, -2), (3.2, 4, -2)], False),  # ends too near
        ([(1, 4, -2), (7, 4, -2)], False),  # leads through
        ([(1, 2, -2), (7, 2, -2)], True),
        ([(1, 2, -2), (7, 2, -2), (7, 4, -2), (4, 4, -2)], False),  # later
        ([(3.2, 4, -2), (2, 4, -2)], True),  # begins too near, and leads away
        ([(3.2, 4, -2), (3.2, 2, -2)], True),  # along the crate
        ([(3.2, 4, -2), (3.4, 4, -2), (1, 4, -2)], False),  # nearer still
        ([(3.2, 2.0, -2), (3.2, 4, -2)], False),  # comes too near
        ([(3.2, 4, -2), (4.8, 4, -2), (7, 4, -2)], False),  # through, from too near
    ],
)
def test_whether_a_path_is_clear(path: list[tuple[float, float, float]], is_clear: bool) -> None:
    assert RouteMap(EMPTY, {}, WIDE, 0.5).is_clear(np.array(path))
    assert with_crate().is_clear(np.array(path)) is is_clear


@pytest.mark.parametrize(("begin", "end"), [(0.0, 1.0), (0.3, 0.6), (0.1, 2.0), (1.0, 1.0)])
def test_a_part_of_a_path_ends_where_it_is_cut(begin: float, end: float) -> None:
    """In shares of its length; around the corner of the room's pillar."""
    path = Path(route_of(RouteMap(ROOM, {"B": at(4.5, 8.5)}, WIDE, 0.0), (1.5, 1.5), "B"))
    part = path.between(begin * path.length_m, end * path.length_m)
    last = path.at(min(end * path.length_m, path.length_m - 1e-9))[0]
    assert part[-1] == pytest.approx(last, abs=0.02)
    if begin < 1.0:
        assert part[0] == pytest.approx(path.at(begin * path.length_m)[0])
    flown_m = np.linalg.norm(np.diff(part, axis=0), axis=1).sum()
    assert flown_m == pytest.approx((min(end, 1.0) - begin) * path.length_m, rel=0.02)
