"""Rounded paths and trajectories against the limits that they promise."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from drawn import drawn
from drawn_grids import WIDE, brute_force_distance, distance_to_leg, draw_position, grids
from hypothesis import assume, given
from hypothesis import strategies as st

from companion.motion.grid import OccupancyGrid
from companion.motion.path import Path
from companion.motion.profile import SpeedLimits, flight_time_s
from companion.motion.region import Disc
from companion.motion.routes import PlaceRegion, Route, RouteMap
from companion.motion.trajectory import Trajectory, motion_of, run_out

JERK = 8.0  # m/s3
FAST = drawn(60)


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
