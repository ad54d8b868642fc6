"""Routes on small maps: where they begin and end, and what makes them impossible."""

from __future__ import annotations

import math

import numpy as np
import pytest
from drawn_rooms import EMPTY, ROOM, WIDE, at, grid_of

from companion.geometry import NorthEast, is_in_polygon
from companion.motion.grid import OccupancyGrid, cells_inside
from companion.motion.path import Path
from companion.motion.routes import PlaceRegion, Route, RouteMap


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


def walled_in() -> OccupancyGrid:
    """A passage 1.8 m wide, from west to east."""
    occupied = np.ones((80, 80), dtype=np.bool_)
    occupied[31:49] = False
    return OccupancyGrid(occupied, 0.1, (0.0, 0.0))


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


@pytest.mark.parametrize("added_m", [0.0, 1.0])
def test_from_within_a_region_a_place_at_its_rim_is_reached_whatever_is_kept_from_walls(
    added_m: float,
) -> None:
    """No path along cells leads there: the centre of its cell lies outside."""
    places = {"outer": at(4.0, 2.0, radius_m=4.03), "inner": at(4.0, 6.02)}
    routes = RouteMap(walled_in(), places, WIDE, 0.6)
    routes.add_clearance(added_m)
    outer, inner = (places[name].position for name in ("outer", "inner"))
    route = routes.route(outer, "inner")
    assert route is not None and route.length_m == pytest.approx(math.dist(outer, inner))
    assert routes.distance_m(outer[:2], "inner") == pytest.approx(math.dist(outer, inner))


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
