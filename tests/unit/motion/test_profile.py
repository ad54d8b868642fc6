"""Profiles: closed forms against Ruckig's solutions, and what is left of a way while braking."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
import ruckig

from companion.motion.profile import (
    REST,
    Motion,
    SpeedLimits,
    flight_time_s,
    quickest,
)

LIMITS = SpeedLimits(2.0, 2.0, 8.0)


def solved(start: Motion, to_mps: float, limits: SpeedLimits) -> tuple[float, float]:
    """Time and way of the quickest change of speed, wherever it leads."""
    asked = ruckig.InputParameter(1)
    asked.control_interface = ruckig.ControlInterface.Velocity
    asked.current_velocity, asked.target_velocity = [start.speed_mps], [to_mps]
    asked.current_acceleration = [start.acceleration_mps2]
    asked.max_acceleration, asked.max_jerk = [limits.acceleration_mps2], [limits.jerk_mps3]
    profile = ruckig.Trajectory(1)
    ruckig.Ruckig(1).calculate(asked, profile)
    return profile.duration, profile.at_time(profile.duration)[0][0]


@pytest.mark.parametrize("limits", [LIMITS, SpeedLimits(3.0, 4.0, 8.0), SpeedLimits(1.0, 0.5, 20)])
@pytest.mark.parametrize("speeds", [(0.0, 1.0), (0.9, 0.2), (0.3, 0.35), (1.0, 0.0), (0.7, 0.7)])
def test_a_change_of_speed_is_the_quickest(
    speeds: tuple[float, float], limits: SpeedLimits
) -> None:
    duration_s, way_m = solved(Motion(speeds[0]), speeds[1], limits)
    assert limits.change_s(*speeds) == pytest.approx(duration_s)
    assert limits.change_m(*speeds) == pytest.approx(way_m)


@pytest.mark.parametrize("acceleration_mps2", [-2.0, -0.7, 0.0, 0.7, 2.0])
@pytest.mark.parametrize("speed_mps", [0.3, 1.0, 1.7])
def test_a_stop_takes_the_way_of_the_quickest_brake(
    speed_mps: float, acceleration_mps2: float
) -> None:
    motion = Motion(max(speed_mps, acceleration_mps2**2 / 16), acceleration_mps2)  # not backwards
    _, way_m = solved(motion, 0.0, LIMITS)
    assert LIMITS.stop_m(motion) == pytest.approx(way_m)


def test_what_is_left_of_a_leg_is_the_way_to_a_stop_while_braking() -> None:
    profile = quickest(6.0, REST, 0.0, LIMITS)
    braking_s = LIMITS.change_s(2.0, 0.0)
    for share in (0.0, 0.1, 0.3, 0.5, 0.8, 0.99):
        (along_m,), (speed_mps,), (change_mps2,) = profile.at_time(
            profile.duration - (1 - share) * braking_s
        )
        assert LIMITS.stop_m(Motion(speed_mps, change_mps2)) == pytest.approx(6.0 - along_m)


@pytest.mark.parametrize("distance_m", [0.001, 0.2, 0.5, 1.0, 2.4, 2.6, 30.0])
def test_the_time_of_a_flight_is_that_of_the_profile_that_is_flown(distance_m: float) -> None:
    profile = quickest(distance_m, REST, 0.0, LIMITS)
    assert flight_time_s(distance_m, LIMITS) == pytest.approx(profile.duration)


def test_the_time_of_a_flight_grows_with_its_distance_without_steps() -> None:
    distances_m = np.linspace(0.0, 5.0, 2001)
    times_s = [flight_time_s(d, LIMITS) for d in distances_m.tolist()]
    assert all(a < b for a, b in pairwise(times_s))
    assert max(b - a for a, b in pairwise(times_s[100:])) < 0.01


def test_a_leg_on_which_the_change_does_not_fit_has_no_profile() -> None:
    with pytest.raises(ArithmeticError, match="ruckig"):
        quickest(0.26991964969, Motion(1.0), 0.3, SpeedLimits(1.0, 2.0, 30.64617500984536))
