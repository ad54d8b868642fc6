"""By calculation: a vehicle with PX4's controller keeps the limits of what it is told.

A linear model of mc_pos_control at its default gains (MPC_XY_P, MPC_XY_VEL_P_ACC, _I_ACC, _D_ACC),
the limit MPC_ACC_HOR_MAX, an attitude that follows in 1 / MC_ROLL_P, motors, and a light drag. The
default simulated vehicle has other gains; its flights are tested in tests/flights.
"""

from __future__ import annotations

from pathlib import Path as FilePath

import numpy as np
import numpy.typing as npt
import pytest

from companion.geometry import times
from companion.mission.loader import load_mission
from companion.motion.profile import SpeedLimits
from companion.motion.routes import Route
from companion.motion.trajectory import Trajectory
from companion.planning.flight_times import route_map
from companion.tick import TICK_S
from companion.vehicle_profile import VehicleProfile

MISSIONS = FilePath(__file__).parents[3] / "missions"
QUAD = VehicleProfile()
POSITION_P, VELOCITY_P, VELOCITY_I, VELOCITY_D = 0.95, 1.8, 0.4, 0.2
ATTITUDE_S, MOTOR_S = 1 / 6.5, 0.05
DRAG_PER_S = 0.1
DT_S = 0.005

Array = npt.NDArray[np.float64]


def response(trajectory: Trajectory) -> tuple[Array, Array]:
    """The velocities and accelerations of the vehicle that is told a trajectory from rest."""
    position = np.array(trajectory.sample(0.0).position)
    velocity, thrust, attitude, integral, change = np.zeros((5, 3))
    velocities, changes = [], []
    for tick in range(round((trajectory.duration_s + 2.0) / TICK_S)):
        told = trajectory.sample(tick * TICK_S)
        later = trajectory.sample(tick * TICK_S + QUAD.response_s)
        ahead = np.array(times(later.acceleration, QUAD.feed_forward))
        for _ in range(round(TICK_S / DT_S)):
            error = told.velocity + POSITION_P * (told.position - position) - velocity
            wanted = ahead + VELOCITY_P * error + integral - VELOCITY_D * change
            wanted *= min(
                1.0, QUAD.max_acceleration_mps2 / max(float(np.linalg.norm(wanted)), 1e-9)
            )
            integral = integral + VELOCITY_I * error * DT_S
            attitude = attitude + (wanted - attitude) * DT_S / ATTITUDE_S
            thrust = thrust + (attitude - thrust) * DT_S / MOTOR_S
            change = thrust - DRAG_PER_S * velocity
            velocity = velocity + change * DT_S
            position = position + velocity * DT_S
            velocities.append(velocity)
            changes.append(change)
    return np.array(velocities), np.array(changes)


def assert_limits_are_kept(trajectory: Trajectory, limits: SpeedLimits) -> None:
    velocities, changes = response(trajectory)
    assert np.linalg.norm(velocities, axis=1).max() <= 1.05 * limits.speed_mps
    assert np.linalg.norm(changes, axis=1).max() <= 1.2 * limits.acceleration_mps2


@pytest.mark.parametrize("length_m", [0.5, 3.0, 12.0])
@pytest.mark.parametrize("speed_mps", [1.0, 2.0, 4.0])
def test_on_a_straight_leg(length_m: float, speed_mps: float) -> None:
    limits = SpeedLimits(speed_mps, QUAD.acceleration_mps2, QUAD.jerk_mps3)
    route = Route(np.array([(0.0, 0.0, -2.0), (length_m, 0.0, -2.0)]))
    assert_limits_are_kept(Trajectory(route, limits), limits)


@pytest.mark.parametrize(
    ("name", "start", "goal"),
    [("surveillance", "r2", "r3"), ("corridor", "Shelf", "Bench"), ("hall_of_20", "s1", "s3")],
)
def test_round_the_corners_of_shipped_missions(name: str, start: str, goal: str) -> None:
    mission = load_mission(MISSIONS / f"{name}.yaml")
    route = route_map(mission).route(mission.places[start].position, goal)
    assert route is not None
    trajectory = Trajectory(route, mission.speed_limits)
    assert_limits_are_kept(trajectory, mission.speed_limits)
