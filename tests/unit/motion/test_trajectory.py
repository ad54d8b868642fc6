"""Trajectories: closed forms on single legs, corners, and a vehicle that follows one."""

from __future__ import annotations

import math

import numpy as np
import pytest

from companion.motion.profile import Motion, SpeedLimits, flight_time_s
from companion.motion.routes import Route
from companion.motion.trajectory import AT_REST, Trajectory, run_out

JERK = 8.0  # m/s3


def route_of(*waypoints: tuple[float, float, float]) -> Route:
    return Route(np.array(waypoints, dtype=np.float64))


def test_a_long_leg_is_a_trapezoid_with_rounded_corners() -> None:
    """v/a + a/j up, as much down, and between them what is left at the greatest speed."""
    trajectory = Trajectory(route_of((0, 0, -1), (6, 0, -1)), SpeedLimits(2.0, 1.0, 2.0))
    assert trajectory.duration_s == pytest.approx(2.5 + 0.5 + 2.5)
    for t_s, north_m, speed_mps in [
        (0.5, 2.0 * 0.5**3 / 6, 2.0 * 0.5**2 / 2),  # j t^3 / 6, j t^2 / 2
        (2.5, 2.5, 2.0),
        (2.75, 3.0, 2.0),
        (3.0, 3.5, 2.0),
    ]:
        sample = trajectory.sample(t_s)
        assert sample.position == pytest.approx((north_m, 0, -1))
        assert sample.velocity == pytest.approx((speed_mps, 0, 0))
        assert not sample.is_finished


def test_a_short_leg_is_four_parts_of_greatest_jerk() -> None:
    """d = j t^3 / 32 of the whole time t; the peak, in the middle, is j t^2 / 16."""
    trajectory = Trajectory(route_of((0, 0, 0), (0, 0.2, 0)), SpeedLimits(2.0, 2.0, JERK))
    whole_s = (32 * 0.2 / 8.0) ** (1 / 3)
    assert trajectory.duration_s == pytest.approx(whole_s)
    assert trajectory.sample(whole_s / 2).velocity == pytest.approx((0, 8.0 * whole_s**2 / 16, 0))


def test_before_the_start_and_after_the_end_the_vehicle_rests() -> None:
    trajectory = Trajectory(route_of((0.1, 0.2, -1), (3.3, 0.7, -2)), SpeedLimits(2.0, 1.0, JERK))
    before, after = trajectory.sample(-5.0), trajectory.sample(1e6)
    assert (before.position, before.velocity) == ((0.1, 0.2, -1), (0, 0, 0))
    assert (after.position, after.velocity) == ((3.3, 0.7, -2), (0, 0, 0))
    assert after.is_finished
    assert not before.is_finished


def test_a_route_of_no_length_is_finished_at_once() -> None:
    trajectory = Trajectory(route_of((1, 2, -3), (1, 2, -3)), SpeedLimits(2.0, 1.0, JERK))
    assert trajectory.duration_s == 0.0
    sample = trajectory.sample(0.0)
    assert (sample.position, sample.course_rad, sample.is_finished) == ((1, 2, -3), None, True)


@pytest.mark.parametrize("turn_deg", [5, 30, 90, 150, 180])
def test_at_a_corner_that_is_not_rounded_the_vehicle_stops(turn_deg: float) -> None:
    turn = math.radians(turn_deg)
    end = (10 + 10 * math.cos(turn), 10 * math.sin(turn), 0)
    limits = SpeedLimits(2.0, 2.0, JERK)
    trajectory = Trajectory(route_of((0, 0, 0), (10, 0, 0), end), limits)
    assert trajectory.duration_s == pytest.approx(2 * flight_time_s(10.0, limits))
    at_corner = trajectory.sample(trajectory.duration_s / 2)
    assert at_corner.position == pytest.approx((10, 0, 0), abs=1e-6)
    assert at_corner.velocity == pytest.approx((0, 0, 0), abs=1e-3)


def test_a_waypoint_on_a_straight_line_does_not_slow_the_vehicle() -> None:
    straight = Trajectory(route_of((0, 0, 0), (9, 0, 0)), SpeedLimits(2.0, 1.0, JERK))
    divided = Trajectory(
        route_of((0, 0, 0), (2, 0, 0), (2.1, 0, 0), (9, 0, 0)), SpeedLimits(2.0, 1.0, JERK)
    )
    assert divided.duration_s == pytest.approx(straight.duration_s)


def test_the_course_is_that_of_the_leg_and_of_the_last_one_at_the_end() -> None:
    trajectory = Trajectory(
        route_of((0, 0, 0), (0, -5, 0), (-5, -5, 0)), SpeedLimits(1.0, 1.0, JERK)
    )
    assert trajectory.sample(-1.0).course_rad == trajectory.sample(0.0).course_rad == -math.pi / 2
    last = trajectory.sample(trajectory.duration_s).course_rad
    assert last is not None and abs(last) == pytest.approx(math.pi)
    assert trajectory.sample(1000.0).course_rad == last


def test_a_steep_leg_has_no_course_of_its_own() -> None:
    limits = SpeedLimits(1.0, 1.0, JERK)
    climb = Trajectory(route_of((0, 0, 0), (0, 0, -3)), limits)
    assert climb.sample(1.0).course_rad is None
    after = Trajectory(route_of((0, 0, 0), (0, 5, 0), (0, 5, -3)), limits)
    assert after.sample(after.duration_s - 0.1).course_rad == math.pi / 2


@pytest.mark.parametrize("distance_m", [0.0, 0.3, 4.0, 4.1, 25.0])
def test_flight_time_is_the_duration_of_one_leg(distance_m: float) -> None:
    trajectory = Trajectory(route_of((0, 0, 0), (distance_m, 0, 0)), SpeedLimits(2.0, 1.0, JERK))
    assert flight_time_s(distance_m, SpeedLimits(2.0, 1.0, JERK)) == pytest.approx(
        trajectory.duration_s
    )


def test_flight_time_of_no_route_is_infinite() -> None:
    assert flight_time_s(math.inf, SpeedLimits(2.0, 1.0, JERK)) == math.inf


def test_a_vehicle_in_motion_brakes_on_its_course_before_it_turns_back() -> None:
    start, velocity = (0.0, 0.0, -2.0), (0.0, 2.0, 0.0)
    stop = run_out(start, velocity, AT_REST, SpeedLimits(2.0, 2.0, JERK))
    way_m = 2.0**2 / (2 * 2.0) + 2.0 * 2.0 / (2 * JERK)  # v^2 / 2a + v a / 2j
    assert stop == pytest.approx((0.0, 1.03 * way_m, -2.0))
    trajectory = Trajectory(
        route_of(start, stop, (0, -5, -2)), SpeedLimits(2.0, 2.0, JERK), start=Motion(2.0)
    )
    assert trajectory.sample(0.0).velocity == pytest.approx(velocity)
    assert trajectory.sample(0.5).acceleration == pytest.approx((0, -2, 0))
    samples = [trajectory.sample(t_s) for t_s in np.arange(0.0, 2.0, 0.01).tolist()]
    assert max(sample.position[1] for sample in samples) == pytest.approx(stop[1], abs=0.01)


def test_a_vehicle_in_motion_goes_straight_on_without_braking() -> None:
    trajectory = Trajectory(
        route_of((0, 0, 0), (1, 0, 0), (9, 0, 0)),
        SpeedLimits(2.0, 2.0, JERK),
        start=Motion(2.0),
    )
    assert all(
        trajectory.sample(t_s).velocity == pytest.approx((2.0, 0.0, 0.0))
        for t_s in np.arange(0.0, 3.9, 0.1)
    )


def test_the_speed_at_the_start_is_lowered_to_what_the_route_allows() -> None:
    trajectory = Trajectory(
        route_of((0, 0, 0), (0.25, 0, 0)), SpeedLimits(2.0, 2.0, JERK), start=Motion(5.0)
    )
    per_jerk = 2.0 * 2.0 / (2 * JERK)  # of v^2 / 2a + v a / 2j = 0.25 m
    allowed_mps = -per_jerk + math.sqrt(per_jerk**2 + 2 * 2.0 * 0.25)
    assert trajectory.sample(0.0).velocity == pytest.approx((allowed_mps, 0, 0), rel=0.01)
    assert trajectory.sample(9.0).position == (0.25, 0, 0)


def test_steep_legs_keep_to_the_vertical_limits() -> None:
    limits = SpeedLimits(2.0, 2.0, JERK, climb_mps=1.0, descent_mps=0.6)
    up = route_of((0, 0, 0), (10, 0, 0), (14, 0, -14), (24, 0, -14), (24, 0, -4), (30, 0, -4))
    trajectory = Trajectory(up, limits)
    samples = [trajectory.sample(t / 20) for t in range(round(20 * trajectory.duration_s))]
    assert max(s.velocity[2] for s in samples) == pytest.approx(0.6)
    assert min(s.velocity[2] for s in samples) == pytest.approx(-1.0)
    assert max(math.hypot(*s.velocity) for s in samples) == pytest.approx(2.0)
    assert trajectory.sample(1e6).position == (30, 0, -4)


def test_vertical_limits_that_are_not_reached_change_nothing() -> None:
    route = route_of((0, 0, 0), (10, 0, -2), (14, 5, -1))
    free = SpeedLimits(2.0, 2.0, JERK)
    limited = SpeedLimits(2.0, 2.0, JERK, climb_mps=0.5, descent_mps=0.5)
    assert Trajectory(route, free).duration_s == Trajectory(route, limited).duration_s
