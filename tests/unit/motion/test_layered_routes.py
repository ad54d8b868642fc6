"""Places at different heights and low walls: what is flown, over what, and what it takes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from drawn import drawn
from hypothesis import assume, given
from hypothesis import strategies as st
from polygons import Point, stars

from companion.drawn_maps import Wall, walled
from companion.geometry import Ned, NorthEast, is_in_polygon
from companion.motion.grid import OccupancyGrid, distances_to_edge
from companion.motion.layered_routes import LayeredRoutes
from companion.motion.passage import Passage
from companion.motion.path import Path
from companion.motion.profile import SpeedLimits, flight_time_s
from companion.motion.region import Disc
from companion.motion.routes import PlaceRegion, Route
from companion.motion.trajectory import Trajectory

FENCE: list[NorthEast] = [(0, 0), (0, 16), (12, 16), (12, 0)]
CLEARANCE_M = 0.6
LIMITS = SpeedLimits(2.0, 2.0, 8.0, climb_mps=1.5, descent_mps=1.0)
ACROSS = ((-1.0, 7.0), (-1.0, 8.0), (13.0, 8.0), (13.0, 7.0))
"""From side to side."""
HALF = ((-1.0, 7.0), (-1.0, 8.0), (9.0, 8.0), (9.0, 7.0))
WEST, EAST = (2.0, 3.0), (2.0, 13.0)


NO_BAND = (-math.inf, -math.inf)


def routes_to(
    goal: Ned, *walls: Wall, cell_m: float = 0.25, up_m: tuple[float, float] = NO_BAND
) -> LayeredRoutes:
    cells = np.zeros((math.ceil(12 / cell_m), math.ceil(16 / cell_m)), dtype=np.bool_)
    grid = walled(OccupancyGrid(cells, cell_m, (0.0, 0.0), is_open=True), walls)
    places = {"B": PlaceRegion(goal, Disc(0.5), True)}
    return LayeredRoutes(grid, places, FENCE, CLEARANCE_M, LIMITS, 0.1, up_m=up_m)


def flown(route: Route) -> list[Ned]:
    path = Path(route)
    along = np.linspace(0.0, path.length_m, 120)
    return [path.at(float(metres)).position for metres in along]


def duration_s(route: Route) -> float:
    return Trajectory(route, LIMITS).duration_s


# -- without walls ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("rise_m", "fastest_mps"), [(6.0, 1.5), (-6.0, 1.0)], ids=["climb", "descent"]
)
def test_on_the_spot_the_profile_of_the_vehicle_says_how_long(
    rise_m: float, fastest_mps: float
) -> None:
    """v / a + a / j to get fast and again to get slow, of which half is lost: s / v + v/a + a/j."""
    start, goal = (*WEST, -2.0), (*WEST, -2.0 - rise_m)
    routes = routes_to(goal)
    expected_s = 6.0 / fastest_mps + fastest_mps / 2.0 + 2.0 / 8.0
    assert routes.passage(start, "B").duration_s(LIMITS) == pytest.approx(expected_s)
    route = routes.route(start, "B")
    assert route is not None
    assert duration_s(route) == pytest.approx(expected_s, rel=1e-6)


@drawn(30)
@given(st.floats(0.7, 9.0), st.floats(-9.0, 9.0))
def test_a_slope_takes_what_its_trajectory_takes(away_m: float, rise_m: float) -> None:
    start, goal = (*WEST, -10.0), (WEST[0], WEST[1] + away_m, -10.0 - rise_m)
    routes = routes_to(goal)
    route = routes.route(start, "B")
    assert route is not None
    assert not routes.passage(start, "B").is_stepped
    estimate_s = routes.passage(start, "B").duration_s(LIMITS)
    assert estimate_s == pytest.approx(duration_s(route), rel=0.03, abs=0.3)  # paths along cells
    for sample in (Trajectory(route, LIMITS).sample(t / 5) for t in range(200)):
        assert -LIMITS.climb_mps - 1e-6 <= sample.velocity[2] <= LIMITS.descent_mps + 1e-6
        assert min(10.0, 10.0 + rise_m) - 1e-6 <= -sample.position[2]
        assert -sample.position[2] <= max(10.0, 10.0 + rise_m) + 1e-6


def test_level_flights_cost_what_they_cost_before() -> None:
    way = routes_to((*EAST, -2.0)).passage((*WEST, -2.0), "B")
    assert way.duration_s(LIMITS) == flight_time_s(way.over_ground_m, LIMITS)


# -- over walls ------------------------------------------------------------------------------------


def test_a_wall_is_flown_over_from_the_clearance_above_it_on() -> None:
    wall = Wall(ACROSS, 1.5)
    for up_m, is_over in ((2.1, True), (2.09, False), (1.0, False), (4.0, True)):
        routes = routes_to((*EAST, -up_m), wall)
        route = routes.route((*WEST, -up_m), "B")
        assert (route is not None) is is_over
        assert routes.is_connected((*WEST, -up_m), "B") is is_over
        assert math.isfinite(routes.distance_m((*WEST, -up_m), "B")) is is_over
        assert routes.is_free((5.0, 7.5, -up_m)) is is_over
    assert routes_to((*EAST, -9.0), Wall(ACROSS)).route((*WEST, -9.0), "B") is None


@pytest.mark.parametrize(("from_m", "to_m"), [(1.0, 3.0), (3.0, 1.0)])
def test_from_one_height_to_another_the_wall_is_crossed_at_the_higher_one(
    from_m: float, to_m: float
) -> None:
    routes = routes_to((*EAST, -to_m), Wall(ACROSS, 2.0))
    way, route = routes.passage((*WEST, -from_m), "B"), routes.route((*WEST, -from_m), "B")
    assert way.is_stepped
    assert route is not None
    over = [-down for _, east, down in flown(route) if 7.0 - 0.6 <= east <= 8.0 + 0.6]
    assert over and min(over) == pytest.approx(3.0)
    assert route.waypoints[0].tolist() == [*WEST, -from_m]
    assert route.waypoints[-1].tolist() == [*EAST, -to_m]
    assert way.duration_s(LIMITS) == pytest.approx(duration_s(route), rel=0.03)
    assert routes.is_clear(route.waypoints)
    assert not routes.is_clear(route.waypoints[[0, -1]])


def test_the_quicker_way_is_flown() -> None:
    """Over the wall if the climb takes less than the detour, around it otherwise."""
    wall = Wall(HALF, 2.0)
    high = routes_to((*EAST, -3.0), wall)
    assert high.passage((*WEST, -2.5), "B").is_stepped is True
    level = high.passage((*WEST, -3.0), "B")
    assert level == Passage(level.over_ground_m, 0.0)
    assert level.over_ground_m == pytest.approx(10.0, abs=0.5)
    around = high.passage((9.9, 6.0, -0.7), "B")
    assert around.is_stepped is False
    assert min(-down for *_, down in flown(high.route((9.9, 6.0, -0.7), "B") or _none())) >= 0.7


@pytest.mark.parametrize(("from_m", "to_m"), [(1.0, 1.0), (1.0, 2.0), (2.0, 1.0)])
def test_a_wall_that_is_higher_than_both_ends_is_flown_over(from_m: float, to_m: float) -> None:
    """At the clearance above it, and in the time that is planned."""
    start = (*WEST, -from_m)
    routes = routes_to((*EAST, -to_m), Wall(ACROSS, 2.0), up_m=(0.5, 8.0))
    way, route = routes.passage(start, "B"), routes.route(start, "B")
    assert way.climb_m == pytest.approx(2.0 + CLEARANCE_M - from_m)
    assert routes.is_connected(start, "B") and routes.search(start, "B", 10**6)
    assert route is not None
    path = flown(route)
    assert max(-down for *_, down in path) == pytest.approx(2.0 + CLEARANCE_M)
    over = [-down for _, east, down in path if 7.0 - CLEARANCE_M <= east <= 8.0 + CLEARANCE_M]
    assert over and min(over) == pytest.approx(2.0 + CLEARANCE_M)
    assert path[0] == pytest.approx(start) and path[-1] == pytest.approx((*EAST, -to_m))
    assert way.duration_s(LIMITS) == pytest.approx(duration_s(route), rel=0.03)
    assert routes.is_clear(route.waypoints)


def test_the_top_is_flown_over_within_the_band_alone_and_where_that_is_quicker() -> None:
    start, wall = (*WEST, -1.0), Wall(ACROSS, 2.0)
    assert routes_to((*EAST, -1.0), wall, up_m=(0.5, 2.6)).route(start, "B") is not None
    assert routes_to((*EAST, -1.0), wall, up_m=(0.5, 2.59)).route(start, "B") is None
    for up_m, is_over in ((1.2, True), (7.0, False)):  # a detour of 11 m, or up and down
        routes = routes_to((*EAST, -1.0), Wall(HALF, up_m), up_m=(0.5, 9.0))
        assert routes.passage(start, "B").is_stepped is is_over


@pytest.mark.parametrize(("ceiling_m", "kept_m"), [(8.0, 1.3), (3.0, 1.0), (2.6, 0.6)])
def test_where_the_position_is_not_exact_the_top_is_flown_over_as_much_higher_as_the_band_allows(
    ceiling_m: float, kept_m: float
) -> None:
    start, goal = (*WEST, -1.0), (*EAST, -1.0)
    routes = routes_to(goal, Wall(ACROSS, 2.0), up_m=(0.5, ceiling_m))
    before = routes.version
    routes.add_clearance(0.7)
    assert routes.version > before
    route = routes.route(start, "B")
    assert route is not None and routes.passage(start, "B").climb_m == pytest.approx(1.0 + kept_m)
    assert max(-down for *_, down in flown(route)) == pytest.approx(2.0 + kept_m)
    routes.add_clearance(0.0)
    assert routes.passage(start, "B").climb_m == pytest.approx(1.0 + CLEARANCE_M)


@pytest.mark.parametrize(
    ("wall", "ceiling_m", "climb_m", "is_straight"),
    [(ACROSS, 8.0, 0.6, True), (ACROSS, 2.9, None, True), (HALF, 2.9, None, False)],
    ids=["higher", "as before", "round it"],
)
def test_what_leads_low_over_a_wall_is_flown_last_where_the_position_is_not_exact(
    wall: tuple[Point, ...], ceiling_m: float, climb_m: float | None, is_straight: bool
) -> None:
    """Both ends are 0.7 m above the wall: more than the least clearance, and less than is kept."""
    start, goal = (*WEST, -2.7), (*EAST, -2.7)
    routes = routes_to(goal, Wall(wall, 2.0), up_m=(0.5, ceiling_m))
    plain = routes.passage(start, "B")
    assert plain.climb_m is None and plain.over_ground_m == pytest.approx(10.0, abs=0.1)
    routes.add_clearance(0.7)
    assert routes.search(start, "B", 10**6) and routes.is_connected(start, "B")
    way, route = routes.passage(start, "B"), routes.route(start, "B")
    assert way.climb_m == (None if climb_m is None else pytest.approx(climb_m))
    assert (way.over_ground_m == pytest.approx(10.0, abs=0.1)) is is_straight
    assert route is not None and routes.is_clear(route.waypoints)


def test_the_lowest_of_several_tops_that_leads_there_is_flown_over() -> None:
    tower = Wall(((3.0, 9.0), (3.0, 10.0), (9.0, 10.0), (9.0, 9.0)), 5.0)
    routes = routes_to((*EAST, -1.0), Wall(ACROSS, 2.0), tower, up_m=(0.5, 9.0))
    assert routes.passage((*WEST, -1.0), "B").climb_m == pytest.approx(1.6)


def test_what_is_low_above_a_roof_or_below_the_band_climbs_first() -> None:
    """So a landing there that was interrupted is left."""
    roof = Wall(((0.5, 5.0), (0.5, 11.0), (11.5, 11.0), (11.5, 5.0)), 3.0)
    routes = routes_to((*EAST, -2.0), roof, up_m=(0.5, 9.0))
    low = (6.0, 8.0, -3.3)
    route = routes.route(low, "B")
    assert route is not None
    assert route.waypoints[1].tolist() == pytest.approx([6.0, 8.0, -3.6])
    below = routes_to((*EAST, -2.0), up_m=(1.0, 9.0)).route((*WEST, -0.4), "B")
    assert below is not None
    assert below.waypoints[1].tolist() == [*WEST, -2.0]


def test_straight_below_a_place_there_is_no_level_part() -> None:
    """One of no length could not be flown: its speed was no number."""
    route = routes_to((*WEST, -2.0), up_m=(1.0, 9.0)).route((*WEST, 0.0), "B")
    assert route is not None
    assert route.waypoints.tolist() == [[*WEST, 0.0], [*WEST, -2.0]]
    assert duration_s(route) > 2.0 / LIMITS.climb_mps


def test_what_is_above_the_edge_of_a_roof_leaves_it_level() -> None:
    """Clear of it by its height alone, it would come too near on a slope."""
    roof = Wall(((0.5, 5.0), (0.5, 11.0), (6.0, 11.0), (6.0, 5.0)), 2.5)
    route = routes_to((9.0, 8.0, -1.0), roof, up_m=(0.5, 9.0)).route((6.3, 8.0, -3.25), "B")
    assert route is not None
    assert route.waypoints[1].tolist() == [9.0, 8.0, -3.25]


def _none() -> Route:
    raise AssertionError("there is no route")


def test_in_motion_a_wall_is_crossed_level_or_not_at_all() -> None:
    routes = routes_to((*EAST, -1.0), Wall(ACROSS, 2.0))
    level = routes.route_from_motion((2.0, 3.0, -3.0), (2.0, 4.0, -3.0), "B")
    assert level is not None
    assert level.waypoints[0].tolist() == [2.0, 3.0, -3.0]
    assert level.waypoints[-2].tolist() == [*EAST, -3.0]
    assert routes.is_clear(level.waypoints)
    climbing = routes_to((*EAST, -3.0), Wall(ACROSS, 2.0))
    assert climbing.route_from_motion((2.0, 3.0, -1.0), (2.0, 4.0, -1.0), "B") is None


def test_what_is_seen_counts_in_all_layers() -> None:
    routes = routes_to((*EAST, -3.0), Wall(ACROSS, 2.0))
    assert routes.route((*WEST, -3.0), "B") is not None
    before = routes.version
    seen = routes._grid.occupied.copy()
    seen[:, 40] = True
    routes.see(routes._grid.with_occupied(seen))
    assert routes.version > before
    assert routes.route((*WEST, -3.0), "B") is None


@drawn(25)
@given(
    stars((6.0, 8.0), 0.5, 5.0),
    stars((4.0, 10.0), 0.5, 4.0),
    st.tuples(st.floats(0.5, 5.0), st.floats(0.5, 5.0)),
    st.tuples(st.floats(0.8, 11.2), st.floats(0.8, 15.2), st.floats(-6.0, -1.0)),
    st.tuples(st.floats(0.8, 11.2), st.floats(0.8, 15.2), st.floats(-6.0, -1.0)),
)
def test_every_point_of_a_flight_is_clear_of_every_wall(
    one: list[Point], other: list[Point], tops_m: tuple[float, float], start: Ned, goal: Ned
) -> None:
    """Beside it or above it, by the distance to the polygon itself."""
    walls = [Wall(tuple(one), tops_m[0]), Wall(tuple(other), tops_m[1])]

    def is_clear(at: Ned, slack_m: float) -> bool:
        return all(
            -at[2] >= (wall.up_m or math.inf) + CLEARANCE_M - 2e-3
            or _gap_m(at, wall.corners) >= CLEARANCE_M + slack_m
            for wall in walls
        )

    assume(is_clear(start, 0.4) and is_clear(goal, 0.4))
    assume(math.dist(start[:2], goal[:2]) > 0.1)
    routes = routes_to(goal, *walls)
    route = routes.route(start, "B")
    assert (route is None) is math.isinf(routes.distance_m(start, "B"))
    if route is not None:
        assert all(is_clear(at, -1e-6) for at in flown(route))
        assert routes.is_clear(route.waypoints)


def _gap_m(point: Ned, zone: tuple[Point, ...]) -> float:
    north, east = (np.array([metres]) for metres in point[:2])
    edges = zip(zone, [*zone[1:], zone[0]], strict=True)
    away_m = min(float(distances_to_edge(north, east, edge)[0]) for edge in edges)
    return -away_m if is_in_polygon(point, zone) else away_m
