"""Regions of places: discs and polygons mean the same to all who ask."""

from __future__ import annotations

import math

import numpy as np
import pytest
from drawn import drawn
from hypothesis import assume, given
from hypothesis import strategies as st
from polygons import Point, stars

from companion.geometry import is_in_polygon
from companion.motion.grid import OccupancyGrid
from companion.motion.grid_graph import OFFSETS, edges_entering
from companion.motion.path import Path
from companion.motion.polygons import are_inside, enters_polygon
from companion.motion.region import Area, Disc
from companion.motion.regions import Regions
from companion.motion.routes import PlaceRegion, RouteMap

L_SHAPE = ((0.0, 0.0), (0.0, 6.0), (2.0, 6.0), (2.0, 2.0), (6.0, 2.0), (6.0, 0.0))
CENTRE = (1.0, 1.0, -2.0)


def test_a_disc_is_a_ball_in_the_air_and_an_area_has_no_height() -> None:
    assert Disc(2.0).away_m((0.0, 0.0, -2.0), (0.0, 0.0, -5.0)) == 1.0
    assert Area(L_SHAPE).away_m(CENTRE, (1.0, 5.0, -99.0)) == -1.0
    assert Area(L_SHAPE).away_m(CENTRE, (3.0, 5.0, -2.0)) == 1.0


def test_the_disc_inside() -> None:
    assert Disc(2.0).inner_m(CENTRE) == 2.0
    assert Area(L_SHAPE).inner_m(CENTRE) == 1.0
    assert Area(L_SHAPE).inner_m((1.5, 1.5, 0.0)) == pytest.approx(math.hypot(0.5, 0.5))


@drawn(30)
@given(stars((0.0, 0.0), 0.6, 6.0), st.floats(0.0, 0.5))
def test_waypoints_lie_in_the_region(corners: list[Point], inside_m: float) -> None:
    centre = (0.0, 0.0, -2.0)
    area = Area(tuple(corners))
    points = list(area.waypoints(centre, 48, inside_m))
    assert len(points) <= 48
    for point in points:
        assert is_in_polygon(point, corners)
        assert area.away_m(centre, point) <= -inside_m
        assert point[2] == -2.0


@drawn(40)
@given(stars((0.0, 0.0), 0.6, 6.0), st.integers(0, 999))
def test_a_leg_enters_where_its_points_do(corners: list[Point], seed: int) -> None:
    """By many points along it, each judged by the rule that the fence has."""
    a, b = np.random.default_rng(seed).uniform(-7, 7, (2, 30, 2))
    entered = enters_polygon(a, b, np.array(corners))
    for begin, end, is_entered in zip(a, b, entered, strict=True):
        points = np.linspace(begin, end, 60)
        inside = [is_in_polygon(tuple(point), corners) for point in points.tolist()]
        assert are_inside(points, np.array(corners)).tolist() == inside
        outside = inside.index(False) if not all(inside) else len(inside)
        if any(inside[outside:]):  # it may leave, and come back into another arm
            assert is_entered
        elif is_entered:  # by a corner that no point has met
            gaps = [Area(tuple(corners)).away_m((0, 0, 0), (*point, 0.0)) for point in points]
            assert min(map(abs, gaps)) < np.linalg.norm(end - begin) / 59


@pytest.mark.parametrize("beside_m", [0.0, 0.01, -0.01])
def test_no_route_enters_an_area_whose_edges_lie_between_cells(beside_m: float) -> None:
    square = ((5.0, 7.0), (5.0, 9.0), (8.0, 9.0), (8.0, 7.0))
    corners = tuple((north + beside_m, east + beside_m) for north, east in square)
    grid = OccupancyGrid(np.zeros((48, 64), dtype=np.bool_), 0.25, (0.0, 0.0), is_open=True)
    places = {
        "X": PlaceRegion((6.5, 7.5, -2.0), Area(corners), True),
        "B": PlaceRegion((11.0, 8.1, -2.0), Disc(0.1), True),
    }
    route = RouteMap(grid, places, FENCE, 0.6, 0.1).route((2.5, 8.1, -2.0), "B")
    assert route is not None
    path = Path(route)
    points = (path.at(float(m)).position for m in np.linspace(0.0, path.length_m, 200))
    assert not any(is_in_polygon(tuple(point), corners) for point in points)


def test_no_leg_comes_back_into_another_arm_of_the_area_that_it_leaves() -> None:
    corners = ((5.0, 7.0), (5.0, 9.0), (6.0, 9.0), (6.0, 8.0), (7.0, 8.0), (7.0, 9.0), (8.0, 9.0))
    area = Area((*corners, (8.0, 7.0)))
    grid = OccupancyGrid(np.zeros((48, 64), dtype=np.bool_), 0.25, (0.0, 0.0), is_open=True)
    places = {
        "X": PlaceRegion((6.5, 7.5, -2.0), area, True),
        "B": PlaceRegion((11.0, 8.6, -2.0), Disc(0.1), True),
    }
    route = RouteMap(grid, places, FENCE, 0.6, 0.1).route((5.5, 8.6, -2.0), "B")
    assert route is not None
    path = Path(route)
    points = (path.at(float(m)).position for m in np.linspace(0.0, path.length_m, 200))
    inside = [is_in_polygon(tuple(point), area.corners) for point in points]
    assert inside[0] and not any(inside[inside.index(False) :])


@drawn(30)
@given(stars((6.2, 7.1), 0.6, 6.0), st.booleans())
def test_edges_into_an_area_are_those_that_enter_it(corners: list[Point], is_round: bool) -> None:
    """Of all edges of the map, not only of those near its border, also where that is on lines."""
    if is_round:
        corners = [(round(row), round(col)) for row, col in corners]
    shape, polygon = (13, 15), np.array(corners)
    regions = Regions(("X",), np.array([[6.2, 7.1]]), np.array([6.0]), {"X": polygon})
    cells = np.argwhere(np.ones(shape)).astype(np.float64)
    ends = cells[:, None] + OFFSETS
    is_on_map = np.all((ends >= 0) & (ends < shape), axis=-1)
    enter = enters_polygon(cells[:, None] + 0.5, ends + 0.5, polygon) & is_on_map
    found = edges_entering(shape, regions).outgoing.reshape(-1)
    expected = np.sum(enter * (1 << np.arange(len(OFFSETS))), axis=1)
    assert found.tolist() == expected.tolist()


FENCE = [(0.0, 0.0), (0.0, 16.0), (12.0, 16.0), (12.0, 0.0)]
POINTS = st.tuples(st.floats(0.8, 11.2), st.floats(0.8, 15.2))


@drawn(20)
@given(stars((6.0, 8.0), 0.6, 4.0), POINTS, POINTS)
def test_no_route_enters_the_area_of_another_place(
    corners: list[Point], start: Point, goal: Point
) -> None:
    assume(not is_in_polygon(goal, corners) and math.dist(start, goal) > 0.5)
    grid = OccupancyGrid(np.zeros((48, 64), dtype=np.bool_), 0.25, (0.0, 0.0), is_open=True)
    places = {
        "X": PlaceRegion((6.0, 8.0, -2.0), Area(tuple(corners)), True),
        "B": PlaceRegion((*goal, -2.0), Disc(0.1), True),
    }
    route = RouteMap(grid, places, FENCE, 0.6, 0.1).route((*start, -2.0), "B")
    if route is None:
        return
    path = Path(route)
    along = np.linspace(0.0, path.length_m, 80)
    inside = [is_in_polygon(path.at(float(m)).position, corners) for m in along]
    left = inside.index(False)
    assert not any(inside[left:])
    assert not left or is_in_polygon(start, corners)
