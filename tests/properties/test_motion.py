"""Distance fields, routes and trajectories against brute force and closed forms.

Geometry is checked here by other means than in the program: cells by the separating axis
theorem on all cells at once, distances over all pairs, optima by a visibility graph.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import networkx as nx
import numpy as np
import numpy.typing as npt
import pytest
from drawn import drawn
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy import ndimage

from companion.geometry import NorthEast
from companion.motion.free_space import ENTRY_M
from companion.motion.grid import OccupancyGrid
from companion.motion.line_of_sight import LineOfSight
from companion.motion.path import Path
from companion.motion.profile import SpeedLimits, flight_time_s
from companion.motion.region import Disc
from companion.motion.regions import Regions
from companion.motion.routes import PlaceRegion, Route, RouteMap
from companion.motion.trajectory import Trajectory, motion_of, run_out

JERK = 8.0  # m/s3


FAST = drawn(60)
WIDE: list[NorthEast] = [(-99, -99), (-99, 99), (99, 99), (99, -99)]
Array = npt.NDArray[np.floating[Any]]


@st.composite
def grids(draw: st.DrawFn, edge: int = 16, boxes: int = 5) -> OccupancyGrid:
    """Rooms with boxes in them."""
    rows, cols = draw(st.integers(6, edge)), draw(st.integers(6, edge))
    occupied = np.zeros((rows, cols), dtype=np.bool_)
    for _ in range(draw(st.integers(0, boxes))):
        row, col = draw(st.integers(0, rows - 1)), draw(st.integers(0, cols - 1))
        height, width = draw(st.integers(1, 6)), draw(st.integers(1, 6))
        occupied[row : row + height, col : col + width] = True
    origin = (draw(st.sampled_from([0.0, -2.0, 0.37])), draw(st.sampled_from([0.0, -1.3])))
    return OccupancyGrid(occupied, draw(st.sampled_from([0.1, 0.25, 1.0])), origin)


def draw_position(data: st.DataObject, grid: OccupancyGrid, cells: list[list[int]]) -> NorthEast:
    """A position inside one of some cells."""
    row, col = data.draw(st.sampled_from(cells))
    inside = st.floats(0.02, 0.98)
    return (
        grid.origin[0] + (row + data.draw(inside)) * grid.cell_m,
        grid.origin[1] + (col + data.draw(inside)) * grid.cell_m,
    )


def brute_force_distance(grid: OccupancyGrid) -> Array:
    """Least gap between each cell and an occupied one, or the rim, edge to edge."""
    occupied = np.argwhere(np.pad(grid.occupied, 1, constant_values=True)) - 1
    cells = np.argwhere(np.ones_like(grid.occupied))
    gaps = np.maximum(np.abs(cells[:, None] - occupied[None]) - 1, 0)
    gaps[np.all(cells[:, None] == occupied[None], axis=2)] = 0
    distance = np.linalg.norm(gaps, axis=2).min(axis=1)
    return np.asarray(distance.reshape(grid.occupied.shape) * grid.cell_m)


def meets(a: Array, b: Array, cells: Array, grown: float) -> npt.NDArray[np.bool_]:
    """Whether segments a-b (n, 2) meet squares (m, 2), each side moved outwards: (n, m) bool.

    Separating axes of a segment and a square: rows, columns and the segment's normal.
    """
    half = 0.5 + grown
    middle = (a + b)[:, None] / 2 - (cells[None] + 0.5)
    reach = np.abs(b - a)[:, None] / 2
    leg = (b - a)[:, None]
    across = np.abs(leg[..., 0] * middle[..., 1] - leg[..., 1] * middle[..., 0])
    is_near = np.all(np.abs(middle) <= half + reach, axis=-1)
    return np.asarray(is_near & (across <= half * np.abs(leg).sum(axis=-1)))


def distance_to_leg(a: Array, b: Array, point: Array) -> float:
    leg = b - a
    share = float(np.clip((point - a) @ leg / max(float(leg @ leg), 1e-12), 0.0, 1.0))
    return float(np.linalg.norm(a + share * leg - point))


@FAST
@given(grids())
def test_the_distance_field_equals_brute_force(grid: OccupancyGrid) -> None:
    np.testing.assert_allclose(grid.distance_m, brute_force_distance(grid), atol=1e-12)


@FAST
@given(grids(), st.data())
def test_line_of_sight_agrees_with_separating_axes(
    grid: OccupancyGrid, data: st.DataObject
) -> None:
    rows, cols = grid.occupied.shape
    quarter = st.tuples(st.integers(0, 4 * rows), st.integers(0, 4 * cols))  # corners, edges too
    a, b = (np.array(data.draw(quarter)) / 4 for _ in range(2))
    framed = np.argwhere(np.pad(grid.occupied, 1, constant_values=True)) - 1.0
    expected = not meets(a[None], b[None], framed, grown=1e-7).any()
    assert bool(LineOfSight(~grid.occupied).is_clear(a, b)) is expected


@FAST
@given(grids(boxes=2), st.integers(0, 999))
def test_a_quick_look_dismisses_no_clear_leg_and_most_others(
    grid: OccupancyGrid, seed: int
) -> None:
    sight, chance = LineOfSight(~grid.occupied), np.random.default_rng(seed)
    a, b = chance.integers(0, 4 * np.array(grid.occupied.shape) + 1, (2, 200, 2)) / 4
    is_clear, may_be_clear = sight.is_clear(a, b), sight.may_be_clear(a, b)
    assert may_be_clear[is_clear].all()
    is_inside = ((a > 0) & (b > 0) & (a < grid.occupied.shape) & (b < grid.occupied.shape)).all(1)
    dismissed = np.count_nonzero(~may_be_clear & is_inside)
    assert dismissed >= 0.5 * np.count_nonzero(~is_clear & is_inside)


@FAST
@given(grids(), st.data())
def test_the_distance_of_a_position_is_that_to_the_nearest_edge(
    grid: OccupancyGrid, data: st.DataObject
) -> None:
    position = draw_position(data, grid, np.argwhere(np.ones_like(grid.occupied)).tolist())
    cells = np.argwhere(np.pad(grid.occupied, 1, constant_values=True)) - 1
    point = (np.array(position) - grid.origin) / grid.cell_m
    gaps = np.maximum(np.maximum(cells - point, point - cells - 1), 0)
    nearest_m = np.linalg.norm(gaps, axis=1).min() * grid.cell_m
    assert grid.clearance_m(position) == pytest.approx(nearest_m, abs=1e-9)
    assert grid.distance_m[grid.cell(position)] <= nearest_m + 1e-9
    for distance_m in (0.0, data.draw(st.floats(0, 2 * nearest_m + 1)), nearest_m + 1e-6):
        assert grid.is_within(position, distance_m) is (grid.clearance_m(position) < distance_m)


@FAST
@given(grids(edge=24), st.floats(0.5, 4.0), st.data())
def test_added_clearance_is_kept_where_there_is_room_and_closes_no_way(
    grid: OccupancyGrid, added: float, data: st.DataObject
) -> None:
    """A route exists exactly if one does without, and keeps it all where the map allows that."""
    least_m = grid.cell_m
    free = np.argwhere(brute_force_distance(grid) >= least_m).tolist()
    assume(free)
    start, goal = draw_position(data, grid, free), draw_position(data, grid, free)
    routes = RouteMap(grid, {"goal": PlaceRegion((*goal, -2.0), Disc(0.5), True)}, WIDE, least_m)
    plain = routes.route((*start, -1.0), "goal")
    routes.add_clearance(added * grid.cell_m)
    wide = routes.route((*start, -1.0), "goal")
    assert (wide is None) == (plain is None)
    if wide is None:
        return
    assert routes.is_clear(wide.waypoints)
    wanted_m = least_m + added * grid.cell_m
    room = brute_force_distance(grid) >= wanted_m
    parts = ndimage.label(room)[0]
    if room[grid.cell(start)] and parts[grid.cell(start)] == parts[grid.cell(goal)]:
        for a, b in pairwise(wide.waypoints[:, :2]):
            for point in np.linspace(a, b, 20):
                assert grid.clearance_m((point[0], point[1])) >= wanted_m - 1e-6


@FAST
@given(st.integers(0, 999))
def test_regions_around_a_path_are_all_that_its_legs_can_enter(seed: int) -> None:
    chance = np.random.default_rng(seed)
    names = tuple("ABCDEFGH")
    regions = Regions(names, chance.uniform(-20, 20, (8, 2)), chance.uniform(0.1, 6, 8))
    points = chance.uniform(-9, 9, (5, 2))
    around = regions.around(points)
    a, b = points[:, None], points[None]
    assert np.array_equal(around.are_entered(a, b), regions.are_entered(a, b))


@FAST
@given(grids(), st.sampled_from([0.0, 1.0, 1.4]), st.data())
def test_legs_keep_the_clearance_and_exist_where_cells_connect(
    grid: OccupancyGrid, clearance: float, data: st.DataObject
) -> None:
    clearance_m = clearance * grid.cell_m
    is_free = (brute_force_distance(grid) >= clearance_m) & ~grid.occupied
    assume(is_free.any())
    free = np.argwhere(is_free).tolist()
    start, goal = draw_position(data, grid, free), draw_position(data, grid, free)
    routes = RouteMap(
        grid, {"goal": PlaceRegion((*goal, -2.0), Disc(0.5), True)}, WIDE, clearance_m
    )
    route = routes.route((*start, -1.0), "goal")
    parts = ndimage.label(is_free)[0]
    if parts[grid.cell(start)] != parts[grid.cell(goal)]:
        assert route is None and routes.distance_m(start, "goal") == math.inf
        return
    assert route is not None
    assert route.waypoints[0].tolist() == [*start, -1.0]
    assert route.waypoints[-1].tolist() == [*goal, -2.0]
    points = (route.waypoints[:, :2] - grid.origin) / grid.cell_m
    not_free = np.argwhere(~np.pad(is_free, 1)) - 1.0
    assert not meets(points[:-1], points[1:], not_free, grown=-1e-6).any()
    for a, b in pairwise(points):
        for point in np.linspace(a, b, 50) * grid.cell_m + grid.origin:
            assert grid.clearance_m((point[0], point[1])) >= clearance_m - 1e-6


@drawn(25)
@given(grids(edge=14), st.data())
def test_lengths_are_close_to_the_optimum_of_a_visibility_graph(
    grid: OccupancyGrid, data: st.DataObject
) -> None:
    is_free = grid.distance_m >= 2 * grid.cell_m
    free = np.argwhere(is_free)
    assume(len(free) > 1)
    centres = free + 0.5
    first, second = np.triu_indices(len(free), 1)
    not_free = np.argwhere(~is_free).astype(np.float64)
    clear = np.concatenate(
        [
            ~meets(centres[i], centres[j], not_free, grown=1e-7).any(axis=1)
            for i, j in zip(np.array_split(first, 20), np.array_split(second, 20), strict=True)
        ]
    )
    lengths = np.linalg.norm(centres[first] - centres[second], axis=1) * grid.cell_m
    visible = nx.Graph()
    visible.add_nodes_from(range(len(free)))
    visible.add_weighted_edges_from(
        zip(first[clear].tolist(), second[clear].tolist(), lengths[clear].tolist(), strict=True)
    )
    goal = data.draw(st.integers(0, len(free) - 1))
    place = PlaceRegion((*grid.centre(*free[goal].tolist()), 0.0), Disc(0.0), False)
    routes = RouteMap(grid, {"goal": place}, WIDE, 2 * grid.cell_m)
    optimum = nx.single_source_dijkstra_path_length(visible, goal)
    for i, cell in list(enumerate(free.tolist()))[::5]:
        start = grid.centre(*cell)
        route = routes.route((*start, 0.0), "goal")
        assert (route is not None) == (i in optimum)
        if route is not None:
            assert Path(route).length_m <= 1.25 * optimum[i] + 1e-9  # corners may be moved outwards
            assert routes.distance_m(start, "goal") <= 1.03 * optimum[i] + 1e-9
            assert routes.distance_m(start, "goal") >= optimum[i] - 1e-9


@FAST
@given(grids(boxes=3), st.data())
def test_no_route_enters_the_region_of_another_place(
    grid: OccupancyGrid, data: st.DataObject
) -> None:
    free = np.argwhere(~grid.occupied).tolist()
    assume(free)
    start = draw_position(data, grid, free)
    radius = st.floats(0.1, 4.0).map(lambda cells: cells * grid.cell_m)
    places = {
        name: PlaceRegion((*draw_position(data, grid, free), 0.0), Disc(data.draw(radius)), True)
        for name in ("goal", "X", "Y")
    }
    route = RouteMap(grid, places, WIDE, grid.cell_m).route((*start, 0.0), "goal")
    assume(route is not None)
    assert route is not None
    for name in ("X", "Y"):
        centre, radius_m = (
            np.array(places[name].position[:2]),
            places[name].region.inner_m((0, 0, 0)),
        )
        legs = list(pairwise(route.waypoints[:, :2]))
        outside = [i for i, (a, _) in enumerate(legs) if np.linalg.norm(a - centre) >= radius_m]
        for a, b in legs[outside[0] :] if outside else []:  # once outside, outside for good
            assert distance_to_leg(a, b, centre) >= radius_m - 1e-9


@FAST
@given(grids(edge=30, boxes=3), st.data())
def test_routes_do_not_depend_on_what_the_map_was_before(
    grid: OccupancyGrid, data: st.DataObject
) -> None:
    cells = np.argwhere(np.ones_like(grid.occupied)).tolist()
    names = ("A", "B", "X")
    radius = st.floats(0.1, 3.0).map(lambda cells: cells * grid.cell_m)
    places = {
        name: PlaceRegion((*draw_position(data, grid, cells), 0.0), Disc(data.draw(radius)), True)
        for name in names
    }
    start = draw_position(data, grid, cells)
    routes = RouteMap(grid, places, WIDE, grid.cell_m)
    for _ in range(data.draw(st.integers(1, 4))):
        routes.distance_m(start, data.draw(st.sampled_from(names)))
        occupied = grid.occupied.copy()
        row, col = data.draw(st.sampled_from(cells))
        height, width = data.draw(st.sampled_from([(1, 1), (4, 4), (30, 1), (30, 15)]))
        occupied[row : row + height, col : col + width] = data.draw(st.booleans())
        grid = OccupancyGrid(occupied, grid.cell_m, grid.origin)
        routes.see(grid)
    new = RouteMap(grid, places, WIDE, grid.cell_m)
    for name in names:
        assert routes.distance_m(start, name) == pytest.approx(new.distance_m(start, name))
        route, expected = (each.route((*start, 0.0), name) for each in (routes, new))
        assert (route is None) == (expected is None)
        if route is not None and expected is not None:
            np.testing.assert_allclose(route.waypoints, expected.waypoints, rtol=0, atol=1e-9)


@FAST
@given(grids(), st.data())
def test_a_start_beside_the_free_cells_is_left_across_no_obstacle(
    grid: OccupancyGrid, data: st.DataObject
) -> None:
    is_free = grid.distance_m >= 2.5 * grid.cell_m
    band = np.argwhere(~is_free & ~grid.occupied).tolist()
    assume(is_free.any() and band)
    start = draw_position(data, grid, band)
    goal = draw_position(data, grid, np.argwhere(is_free).tolist())
    routes = RouteMap(
        grid, {"goal": PlaceRegion((*goal, 0.0), Disc(0.5), True)}, WIDE, 2.5 * grid.cell_m
    )
    route = routes.route((*start, 0.0), "goal")
    assume(route is not None)
    assert route is not None
    first = (route.waypoints[:2, :2] - grid.origin) / grid.cell_m
    assert np.linalg.norm(first[1] - first[0]) * grid.cell_m <= ENTRY_M + grid.cell_m
    occupied = np.argwhere(grid.occupied).astype(np.float64)
    assert not meets(first[:1], first[1:], occupied, grown=-1e-6).any()
    assert routes.is_clear(route.waypoints) or not any(
        routes.is_clear(np.vstack([start, grid.centre(*cell)]))
        for cell in np.argwhere(is_free).tolist()
        if math.dist(cell, grid.cell(start)) * grid.cell_m <= ENTRY_M
        and math.isfinite(routes.distance_m(grid.centre(*cell), "goal"))
    )


@FAST
@given(grids(edge=24), st.data())
def test_a_rounded_path_keeps_the_clearance_and_enters_no_other_region(
    grid: OccupancyGrid, data: st.DataObject
) -> None:
    """Between the waypoints too: the points that are flown lie in free cells alone."""
    is_free = brute_force_distance(grid) >= 1.5 * grid.cell_m
    free = np.argwhere(is_free).tolist()
    assume(free)
    start = draw_position(data, grid, free)
    places = {
        name: PlaceRegion(
            (*draw_position(data, grid, free), -2.0), Disc(radius * grid.cell_m), True
        )
        for name, radius in (("goal", 0.5), ("X", data.draw(st.floats(0.5, 3.0))))
    }
    assume(math.dist(start, places["X"].position[:2]) > places["X"].region.inner_m((0, 0, 0)))
    route = RouteMap(grid, places, WIDE, 1.5 * grid.cell_m).route((*start, -1.0), "goal")
    assume(route is not None)
    assert route is not None
    path = Path(route)
    assume(path.length_m > 0)
    flown = np.array([path.at(s).position[:2] for s in np.linspace(0, path.length_m, 1000)])
    cells = np.floor((flown - grid.origin) / grid.cell_m).astype(int)
    assert is_free[cells[:, 0], cells[:, 1]].all()
    away_m = np.linalg.norm(flown - places["X"].position[:2], axis=1)
    assert away_m.min() >= places["X"].region.inner_m((0, 0, 0)) - 1e-9


@drawn(30)
@given(grids(edge=24), st.floats(0.3, 4.0), st.floats(0.3, 5.0), st.data())
def test_along_a_rounded_route_neither_velocity_nor_acceleration_jumps(
    grid: OccupancyGrid, speed: float, acceleration: float, data: st.DataObject
) -> None:
    free = np.argwhere(brute_force_distance(grid) >= grid.cell_m).tolist()
    assume(free)
    start, goal = draw_position(data, grid, free), draw_position(data, grid, free)
    routes = RouteMap(
        grid, {"goal": PlaceRegion((*goal, -2.0), Disc(0.5), True)}, WIDE, grid.cell_m
    )
    route = routes.route((*start, -1.0), "goal")
    assume(route is not None)
    assert route is not None
    trajectory = Trajectory(route, SpeedLimits(speed, acceleration, JERK))
    times, dt_s = np.linspace(0, trajectory.duration_s, 1000, retstep=True)
    samples = [trajectory.sample(float(t_s)) for t_s in times]
    velocities = np.array([sample.velocity for sample in samples])
    changes = np.array([sample.acceleration for sample in samples])
    assert np.linalg.norm(velocities, axis=1).max() <= speed + 1e-6
    assert np.linalg.norm(changes, axis=1).max() <= acceleration + 1e-6
    assert np.linalg.norm(np.diff(velocities, axis=0), axis=1).max() <= acceleration * dt_s + 1e-6
    most_mps3 = JERK * math.hypot(1, math.pi)  # across, and along in a turn by 180 degrees
    assert np.linalg.norm(np.diff(changes, axis=0), axis=1).max() <= most_mps3 * dt_s + 1e-5


coordinates = st.floats(-10, 10).map(lambda x: round(x, 2))
waypoints = st.lists(st.tuples(coordinates, coordinates, coordinates), min_size=2, max_size=6)
speeds, accelerations = st.floats(0.3, 4.0), st.floats(0.3, 5.0)
jerks = st.floats(2.0, 40.0)


@FAST
@given(waypoints, speeds, accelerations)
def test_a_trajectory_keeps_its_limits_and_its_route(
    corners: list[tuple[float, float, float]], speed: float, acceleration: float
) -> None:
    route = Route(np.array(corners))
    trajectory = Trajectory(route, SpeedLimits(speed, acceleration, JERK))
    times, dt_s = np.linspace(-0.1, trajectory.duration_s + 0.1, 1500, retstep=True)
    samples = [trajectory.sample(float(t_s)) for t_s in times]
    positions = np.array([sample.position for sample in samples])
    velocities = np.array([sample.velocity for sample in samples])
    changes = np.array([sample.acceleration for sample in samples])
    rates = np.linalg.norm(velocities, axis=1)

    assert positions[0].tolist() == list(corners[0])
    assert positions[-1].tolist() == list(corners[-1])
    assert rates.max() <= speed + 1e-9
    assert np.linalg.norm(changes, axis=1).max() <= acceleration + 1e-9
    # Within 1e-15 m of a corner, (6e-15 / JERK)^(1/3) s, either leg may say where it leads.
    either_mps2 = 2 * JERK * (6e-15 / JERK) ** (1 / 3)
    assert np.linalg.norm(np.diff(changes, axis=0), axis=1).max() <= JERK * dt_s + either_mps2
    assert np.abs(np.diff(rates)).max() <= acceleration * dt_s + 1e-9
    steps = np.linalg.norm(np.diff(positions, axis=0), axis=1)
    assert np.all(steps <= (rates[:-1] + rates[1:]) / 2 * dt_s + acceleration * dt_s**2 + 1e-9)
    assert steps.sum() <= route.length_m + 1e-6
    for position in positions[::50]:
        off_m = min(distance_to_leg(a, b, position) for a, b in pairwise(route.waypoints))
        assert off_m < 1e-9


@FAST
@given(waypoints, speeds, accelerations)
def test_a_route_takes_longer_than_its_length_in_a_straight_line_but_not_than_stopping(
    corners: list[tuple[float, float, float]], speed: float, acceleration: float
) -> None:
    route = Route(np.array(corners))
    legs, limits = (
        [math.dist(a, b) for a, b in pairwise(corners)],
        SpeedLimits(speed, acceleration, JERK),
    )
    duration_s = Trajectory(route, limits).duration_s
    assert flight_time_s(route.length_m, limits) <= duration_s + 1e-6
    assert duration_s <= sum(flight_time_s(leg, limits) for leg in legs) + 1e-6


@FAST
@given(speeds, accelerations, jerks, st.floats(0.0, 1.0), st.floats(0.0, 30.0))
def test_the_speed_that_is_reached_is_the_greatest_for_its_way(
    speed: float, acceleration: float, jerk: float, share: float, within_m: float
) -> None:
    limits = SpeedLimits(speed, acceleration, jerk)
    reached_mps = limits.reached_mps(share * speed, within_m)
    assert share * speed <= reached_mps <= speed
    way_m = limits.change_m(share * speed, reached_mps)
    assert way_m <= within_m + 1e-6
    assert reached_mps == speed or way_m >= within_m - 1e-6


@FAST
@given(waypoints, speeds, accelerations, jerks, st.floats(0.0, 1.0), st.floats(0.1, 9.0))
def test_a_turn_in_flight_goes_on_from_the_motion_and_keeps_the_limits(
    corners: list[tuple[float, float, float]],
    speed: float,
    acceleration: float,
    jerk: float,
    share: float,
    on_m: float,
) -> None:
    """By way of where the vehicle can stop; position, speed and acceleration do not jump."""
    limits = SpeedLimits(speed, acceleration, jerk)
    flown = Trajectory(Route(np.array(corners)), limits)
    now = flown.sample(share * flown.duration_s)
    motion = motion_of(now.velocity, now.acceleration)
    assume(motion.speed_mps > 0.05)
    stop = run_out(now.position, now.velocity, now.acceleration, limits)
    assert math.dist(now.position, stop) >= limits.stop_m(motion)
    for further in ([], [(stop[0] + on_m, stop[1] - 1.0, stop[2])]):
        route = Route(np.array([now.position, stop, *further]))
        turned = Trajectory(route, limits, motion)
        first = turned.sample(0.0)
        assert np.allclose(first.position, now.position, atol=1e-9)
        assert np.allclose(first.velocity, now.velocity, atol=1e-6)
        assert np.allclose(first.acceleration, now.acceleration, atol=1e-6)
        times, dt_s = np.linspace(0.0, turned.duration_s, 700, retstep=True)
        samples = [turned.sample(float(t_s)) for t_s in times]
        changes = np.array([sample.acceleration for sample in samples])
        rates = np.linalg.norm([sample.velocity for sample in samples], axis=1)
        assert rates.max() <= speed + 1e-6
        assert np.linalg.norm(changes, axis=1).max() <= acceleration + 1e-6
        assert np.linalg.norm(np.diff(changes, axis=0), axis=1).max() <= jerk * dt_s + 1e-5
        for sample in samples[::40]:
            position = np.array(sample.position)
            assert min(distance_to_leg(a, b, position) for a, b in pairwise(route.waypoints)) < 1e-6
