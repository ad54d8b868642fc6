"""How much of a detour routes make to keep more from obstacles.

A hall of 30 by 20 m with a wall across it, which has a gap at 15 m and a wide one at its end: the
way through the gap is 8 m long, round the end of the wall 30 m.
"""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest
from drawn_rooms import WIDE, at

from companion.geometry import NorthEast
from companion.motion.cost_to_go import ALL, CostToGo
from companion.motion.distance_maps import DistanceMaps
from companion.motion.grid import OccupancyGrid
from companion.motion.routes import RouteMap

CELL_M = 0.1
LEAST_M, ADDED_M = 0.6, 0.7
START, PLACE = (15.05, 6.05), "B"


def hall(gap_m: float, end_m: float = 3.0) -> OccupancyGrid:
    """The hall; the gap's edges are on those of cells.

    Args:
        gap_m: as wide is the gap.
        end_m: as wide is what the wall leaves at its end.
    """
    occupied = np.zeros((300, 200), dtype=np.bool_)
    occupied[round(end_m / CELL_M) :, 100] = True
    half = round(gap_m / CELL_M / 2)
    occupied[150 - half : 150 + half, 100] = False
    return OccupancyGrid(occupied, CELL_M, (0.0, 0.0))


def routes_in(grid: OccupancyGrid) -> RouteMap:
    """With what a position that is exact to 0.28 m adds."""
    routes = RouteMap(grid, {PLACE: at(15.05, 14.05)}, WIDE, LEAST_M)
    routes.add_clearance(ADDED_M)
    return routes


def flown(routes: RouteMap, grid: OccupancyGrid, start: NorthEast = START) -> tuple[float, float]:
    """Length and least clearance of the route, m."""
    route = routes.route((*start, -2.0), PLACE)
    assert route is not None
    points = np.vstack(
        [np.linspace(*leg, 200) for leg in zip(route.waypoints, route.waypoints[1:], strict=False)]
    )
    return route.length_m, min(grid.clearance_m((p[0], p[1])) for p in points)


@pytest.mark.parametrize(
    ("gap_m", "goes_through", "kept_m"),
    [
        (3.0, True, 1.3),  # wide enough for all that is added
        (2.6, True, 1.2),  # a step less of it, and a quarter of the way
        (2.4, True, 1.1),  # two thirds of it: enough
        (2.2, False, 1.3),  # less than that
    ],
)
def test_a_long_way_round_is_flown_only_for_a_large_part_of_the_clearance(
    gap_m: float, goes_through: bool, kept_m: float
) -> None:
    grid = hall(gap_m)
    length_m, clearance_m = flown(routes_in(grid), grid)
    assert (length_m < 9.0) is goes_through
    assert clearance_m >= kept_m - 1e-6


def test_a_narrow_gap_is_flown_through_where_nothing_else_leads_there() -> None:
    grid = hall(1.6, end_m=0.0)
    length_m, clearance_m = flown(routes_in(grid), grid)
    assert length_m < 9.0 and clearance_m >= 0.7 - 1e-6


def test_a_narrow_gap_does_not_let_the_rest_of_the_way_be_near_to_walls() -> None:
    """A box stands on the straight way to a gap of 1.4 m, 6 m before it."""
    occupied = hall(1.4, end_m=0.0).occupied.copy()
    occupied[145:200, 30:40] = True
    grid = OccupancyGrid(occupied, CELL_M, (0.0, 0.0))
    route = routes_in(grid).route((15.05, 2.05, -2.0), PLACE)
    assert route is not None
    legs = zip(route.waypoints, route.waypoints[1:], strict=False)
    points = np.vstack([np.linspace(*leg, 200) for leg in legs])
    before = [(p[0], p[1]) for p in points if 3.4 < p[1] < 8.5]
    assert min(grid.clearance_m(point) for point in before) >= 1.1 - 1e-6  # two thirds of it


def test_a_way_that_is_hardly_longer_keeps_it_all() -> None:
    """Between a gap of 2.4 m and a wide one, to both of which it is about 1.2 m aside."""
    occupied = hall(2.4).occupied.copy()
    occupied[163:220, 100] = False
    grid = OccupancyGrid(occupied, CELL_M, (0.0, 0.0))
    routes = RouteMap(grid, {PLACE: at(16.25, 14.05)}, WIDE, LEAST_M)
    routes.add_clearance(ADDED_M)
    length_m, clearance_m = flown(routes, grid, (16.25, 6.05))
    assert 8.4 < length_m < 8.8 and clearance_m >= 1.3 - 1e-6


@pytest.mark.parametrize("gap_m", [3.0, 2.6, 2.2])
def test_distance_and_route_agree(gap_m: float) -> None:
    routes = routes_in(hall(gap_m))
    route = routes.route((*START, -2.0), PLACE)
    assert route is not None
    assert routes.distance_m(START, PLACE) == pytest.approx(route.length_m, rel=0.1)


@pytest.mark.parametrize("gap_m", [3.0, 2.6, 2.4, 2.2])
def test_once_the_ways_are_known_nothing_more_is_searched(gap_m: float) -> None:
    """In parts of 500 cells, of 60,000 at each clearance."""
    grid = hall(gap_m)
    routes, parts = routes_in(grid), 0
    while not routes.search(START, PLACE, 500):
        parts += 1
    assert parts > 3 or gap_m == 3.0
    assert routes.search(START, PLACE, 0)
    assert routes.distance_m(START, PLACE) == routes_in(grid).distance_m(START, PLACE)


def test_at_lower_clearances_those_places_alone_are_searched_that_are_flown_to_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A gap of 1.6 m: of the eight clearances the lower ones lead to one of three places."""
    grid, begun = hall(1.6, end_m=0.0), Counter[str]()
    places = {PLACE: at(15.05, 14.05), "Near": at(20.05, 4.05), "Far": at(5.05, 4.05)}
    routes = RouteMap(grid, places, WIDE, LEAST_M)
    routes.add_clearance(ADDED_M)
    assert all(routes.route((*START, -2.0), place) is not None for place in places)
    counted = DistanceMaps._begun

    def counting(maps: DistanceMaps, place: str) -> CostToGo | None:
        begun[place] += 1
        return counted(maps, place)

    monkeypatch.setattr(DistanceMaps, "_begun", counting)
    other = grid.occupied.copy()
    other[280, 30] = True
    routes.see(OccupancyGrid(other, CELL_M, (0.0, 0.0)))
    assert routes.find(ALL)
    assert begun["Near"] == begun["Far"] == 1 < begun[PLACE]


def test_where_no_way_leads_there_none_is_found() -> None:
    routes = routes_in(hall(0.8, end_m=0.0))
    assert routes.search(START, PLACE, 500)
    assert routes.distance_m(START, PLACE) == math.inf
    assert routes.route((*START, -2.0), PLACE) is None
