"""Keep-out zones: no route enters one; from inside one, the shortest way leads out."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from drawn import drawn
from hypothesis import assume, given
from hypothesis import strategies as st
from polygons import Point, stars

from companion.geometry import NorthEast, is_in_polygon
from companion.motion.grid import OccupancyGrid, distances_to_edge
from companion.motion.path import Path
from companion.motion.region import Disc
from companion.motion.routes import PlaceRegion, Route, RouteMap

FENCE: list[NorthEast] = [(0, 0), (0, 16), (12, 16), (12, 0)]
CLEARANCE_M = 0.6


def field(cell_m: float = 0.1) -> OccupancyGrid:
    cells = np.zeros((math.ceil(12 / cell_m), math.ceil(16 / cell_m)), dtype=np.bool_)
    return OccupancyGrid(cells, cell_m, (0.0, 0.0), is_open=True)


def routes_to(goal: NorthEast, *zones: list[Point], grid: OccupancyGrid | None = None) -> RouteMap:
    place = PlaceRegion((*goal, -2.0), Disc(0.5), True)
    return RouteMap(grid or field(), {"B": place}, FENCE, CLEARANCE_M, 0.1, zones)


def gap_m(point: NorthEast, zone: list[Point]) -> float:
    """To the nearest edge, negative inside."""
    north, east = (np.array([metres]) for metres in point)
    edges = zip(zone, [*zone[1:], zone[0]], strict=True)
    away_m = min(float(distances_to_edge(north, east, edge)[0]) for edge in edges)
    return -away_m if is_in_polygon(point, zone) else away_m


def flown(route: Route) -> list[NorthEast]:
    path = Path(route)
    along = np.linspace(0.0, path.length_m, 60)
    return [path.at(float(metres)).position[:2] for metres in along]


ZONES = stars((6.0, 8.0), 0.4, 4.5)
CELLS = st.sampled_from([0.1, 0.25, 0.5])
POINTS = st.tuples(st.floats(0.8, 11.2), st.floats(0.8, 15.2))


@drawn(20)
@given(ZONES, POINTS, POINTS, CELLS)
def test_no_route_comes_nearer_to_a_zone_than_the_clearance(
    zone: list[Point], start: NorthEast, goal: NorthEast, cell_m: float
) -> None:
    """By distances to the polygon itself, along the rounded path."""
    diagonal_m = 1.5 * cell_m
    assume(min(gap_m(start, zone), gap_m(goal, zone)) >= CLEARANCE_M + diagonal_m)
    assume(math.dist(start, goal) > 0.1)
    route = routes_to(goal, zone, grid=field(cell_m)).route((*start, -2.0), "B")
    if route is None:  # the zone leaves no way between itself and the fence
        return
    assert min(gap_m(point, zone) for point in flown(route)) >= CLEARANCE_M - 1e-6
    assert route.waypoints[-1, :2].tolist() == [*goal]


@drawn(20)
@given(stars((6.0, 8.0), 1.5, 4.5), st.floats(0, 7), st.floats(0, 1), CELLS)
def test_from_a_zone_the_first_leg_is_about_the_shortest_way_out(
    zone: list[Point], angle: float, away_m: float, cell_m: float
) -> None:
    """The nearest free cell is a cell or two further than the nearest point with room."""
    start = (6.0 + away_m * math.cos(angle), 8.0 + away_m * math.sin(angle))
    assume(gap_m(start, zone) < -cell_m)
    goal = (1.0, 1.0)
    assume(gap_m(goal, zone) > CLEARANCE_M + 2 * cell_m)
    routes = routes_to(goal, zone, grid=field(cell_m))
    route = routes.route((*start, -2.0), "B")
    if route is None:
        return
    first = route.waypoints[1, :2]
    assert gap_m(tuple(first.tolist()), zone) >= CLEARANCE_M - 1e-6
    ring = [
        (start[0] + reach * math.cos(angle), start[1] + reach * math.sin(angle))
        for reach in np.arange(0.2, 8.0, 0.2)
        for angle in np.linspace(0, 2 * math.pi, 24)
    ]
    inside = (p for p in ring if 0.7 < p[0] < 11.3 and 0.7 < p[1] < 15.3)
    nearest_m = next(math.dist(start, p) for p in inside if gap_m(p, zone) >= CLEARANCE_M)
    assert math.dist(start, first) <= nearest_m + 0.3 + 4 * cell_m
    gaps = [gap_m(point, zone) for point in flown(route)]
    out = next(i for i, gap in enumerate(gaps) if gap >= CLEARANCE_M - 0.1)
    assert min(gaps[out:]) >= CLEARANCE_M - 0.1  # it does not come back


SQUARE = [(4.0, 6.0), (4.0, 10.0), (8.0, 10.0), (8.0, 6.0)]


def test_a_leg_from_the_edge_of_a_zone_does_not_cross_it() -> None:
    """Beside it the vehicle may have drifted; through it is no way out."""
    routes = routes_to((6.0, 13.0), SQUARE)
    assert routes.is_clear(np.array([(6.0, 5.8), (6.0, 5.0)]))
    assert not routes.is_clear(np.array([(6.0, 5.8), (6.0, 12.0)]))
    assert not routes.is_clear(np.array([(6.0, 3.0), (6.0, 13.0)]))


def test_out_of_a_zone_is_clear_and_into_it_is_not() -> None:
    routes = routes_to((6.0, 13.0), SQUARE)
    assert routes.is_clear(np.array([(6.0, 9.0), (6.0, 11.0)]))
    assert not routes.is_clear(np.array([(6.0, 9.0), (6.0, 8.0)]))
    assert routes.route_from_motion((6.0, 9.0, -2.0), (6.0, 8.5, -2.0), "B") is None
    assert routes.route_from_motion((6.0, 9.0, -2.0), (6.0, 11.0, -2.0), "B") is not None


def test_no_way_out_leads_through_a_wall() -> None:
    """It stands just east of the zone, where the way out would be the shortest."""
    walls = field().occupied.copy()
    walls[30:90, 102:106] = True
    walled = field().with_occupied(walls)
    route = routes_to((6.0, 13.0), SQUARE, grid=walled).route((6.0, 9.5, -2.0), "B")
    assert route is not None
    for a, b in pairwise(flown(route)):
        for share in np.linspace(0, 1, 5):
            point = tuple(((1 - share) * np.array(a) + share * np.array(b)).tolist())
            assert walled.clearance_m(point) > 0.0


@pytest.mark.parametrize("added_m", [0.0, 0.5])
def test_a_way_out_comes_no_nearer_to_a_wall_than_it_begins(added_m: float) -> None:
    """A pillar stands in the zone, beside the shortest way out; a metre further on none does."""
    walls = field().occupied.copy()
    walls[61:64, 97:99] = True
    walled = field().with_occupied(walls)
    routes = routes_to((6.0, 13.0), SQUARE, grid=walled)
    routes.add_clearance(added_m)
    start = (6.0, 9.0)
    route = routes.route((*start, -2.0), "B")
    assert route is not None
    least_m = min(walled.clearance_m(start), CLEARANCE_M) - 2 * walled.cell_m
    assert min(walled.clearance_m(point) for point in flown(route)) >= least_m


def test_no_way_leads_out_of_a_zone_past_a_wall_that_it_would_brush() -> None:
    """The place lies in a pocket, whose only opening is 0.4 m wide."""
    walls = field().occupied.copy()
    walls[20:100, 104:106] = True
    walls[58:62, 104:106] = False
    walls[[20, 99], 106:160] = True
    pocket = routes_to((6.0, 13.0), SQUARE, grid=field().with_occupied(walls))
    assert pocket.route((6.0, 9.0, -2.0), "B") is None
    assert not pocket.is_connected((6.0, 9.0), "B")


def test_a_place_that_zones_enclose_cannot_be_reached() -> None:
    ring = [
        [(3.0, 5.0), (3.0, 11.0), (4.0, 11.0), (4.0, 5.0)],
        [(8.0, 5.0), (8.0, 11.0), (9.0, 11.0), (9.0, 5.0)],
        [(3.0, 5.0), (9.0, 5.0), (9.0, 6.0), (3.0, 6.0)],
        [(3.0, 10.0), (9.0, 10.0), (9.0, 11.0), (3.0, 11.0)],
    ]
    assert routes_to((6.0, 8.0), *ring).route((1.0, 1.0, -2.0), "B") is None
    assert routes_to((6.0, 8.0), *ring[:3]).route((1.0, 1.0, -2.0), "B") is not None


def test_a_notch_of_the_fence_that_is_narrower_than_a_cell_is_not_crossed() -> None:
    """No corner of a cell lies in it."""
    notched = [*FENCE, (5.9, 0.0), (5.8, 15.9), (5.7, 0.0)]
    place = PlaceRegion((9.0, 9.0, -2.0), Disc(0.5), True)
    assert RouteMap(field(2.0), {"B": place}, FENCE, 0.6).route((3.0, 9.0, -2.0), "B") is not None
    assert RouteMap(field(2.0), {"B": place}, notched, 0.6).route((3.0, 9.0, -2.0), "B") is None


def test_what_is_seen_does_not_wear_a_zone_away() -> None:
    routes = routes_to((6.0, 13.0), SQUARE)
    seen = field()
    seen.occupied[20:22, 20:22] = True
    routes.see(seen)
    routes.see(field())
    route = routes.route((6.0, 3.0, -2.0), "B")
    assert route is not None
    assert min(gap_m(point, SQUARE) for point in flown(route)) >= CLEARANCE_M - 1e-6
