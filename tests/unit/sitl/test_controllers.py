"""The cascade flies the airframe: steps, tracking, take-off and landing."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from physics_steps import CONTROL_S, DT, driven, flown

from companion.geometry import GlobalOrigin, Ned, euler_from_quaternion, quaternion_from_yaw
from sitl.flight.airframes import AIRFRAMES
from sitl.flight.attitude import attitude_from_thrust, quaternion_from_euler, tilt_and_heading
from sitl.flight.controllers import Cascade, ControllerLimits, TrajectorySetpoint
from sitl.flight.physics import Physics

SEA = GlobalOrigin(47.4, 8.5, 0.0)
NOTHING = (None, None, None)
STILL = (0.0, 0.0, 0.0)
HIGH = (0.0, 0.0, -10.0)


def hovering(wind: Ned = STILL, turbulence_mps: float = 0.0) -> tuple[Physics, Cascade]:
    physics = Physics(origin=SEA, start=HIGH, wind=wind, turbulence_mps=turbulence_mps, seed=1)
    cascade = Cascade()
    cascade.reset(0.0)
    flown(physics, cascade, TrajectorySetpoint(HIGH, STILL), 8.0)
    return physics, cascade


def rise_s(values: list[float], step: float) -> float:
    tenth = next(i for i, value in enumerate(values) if value > 0.1 * step)
    most = next(i for i, value in enumerate(values) if value > 0.9 * step)
    return (most - tenth) * DT


def settle_s(values: list[float], step: float) -> float:
    """When the value enters a band of 2 % for good."""
    return DT * (
        1 + max(i for i, value in enumerate(values) if abs(value - step) > 0.02 * abs(step))
    )


# Steps


def test_roll_step() -> None:
    physics, cascade = hovering()
    sideways = TrajectorySetpoint(
        NOTHING, (None, None, 0.0), (0.0, 9.80665 * math.tan(math.radians(20)), 0.0)
    )
    states = flown(physics, cascade, sideways, 1.0)
    roll = [math.degrees(euler_from_quaternion(state.attitude)[0]) for state in states]
    assert rise_s(roll, 20.0) <= 0.2
    assert max(roll) <= 22.0
    assert roll[-1] == pytest.approx(20.0, abs=0.6)


@pytest.mark.parametrize(
    ("position", "axis", "sign"),
    [((1.0, 0.0, -10.0), 0, 1), ((0.0, -1.0, -10.0), 1, -1), ((0.0, 0.0, -11.0), 2, -1)],
)
def test_position_step(position: Ned, axis: int, sign: int) -> None:
    physics, cascade = hovering()
    start = physics.state.position[axis]
    states = flown(physics, cascade, TrajectorySetpoint(position, STILL), 6.0)
    moved = [sign * (state.position[axis] - start) for state in states]
    assert max(moved) <= 1.05
    assert settle_s(moved, 1.0) <= 2.5


@pytest.mark.parametrize("yaw_rad", [1.0, -3.0])
def test_yaw_step_keeps_the_place(yaw_rad: float) -> None:
    physics, cascade = hovering()
    states = flown(physics, cascade, TrajectorySetpoint(HIGH, STILL, yaw_rad=yaw_rad), 6.0)
    assert euler_from_quaternion(states[-1].attitude)[2] == pytest.approx(yaw_rad, abs=0.01)
    assert max(math.dist(state.position, HIGH) for state in states) < 0.05
    assert max(abs(state.rates[2]) for state in states) < 1.2 * ControllerLimits().yaw_rate_radps


def test_a_yaw_rate_without_a_heading_turns_and_then_holds() -> None:
    physics, cascade = hovering()
    flown(physics, cascade, TrajectorySetpoint(HIGH, STILL, yaw_rate_radps=0.5), 2.0)
    states = flown(physics, cascade, TrajectorySetpoint(HIGH, STILL), 4.0)
    assert euler_from_quaternion(states[-1].attitude)[2] == pytest.approx(1.0, abs=0.02)


def test_a_far_target_is_reached_without_overshoot_and_within_the_limits() -> None:
    physics, cascade = hovering()
    states = flown(physics, cascade, TrajectorySetpoint((40.0, 30.0, -15.0), STILL), 20.0)
    assert max(math.hypot(*state.velocity[:2]) for state in states) <= 5.1
    assert max(-state.velocity[2] for state in states) <= 3.1
    assert max(state.position[0] for state in states) <= 40.1
    assert min(state.position[2] for state in states) >= -15.1
    assert math.dist(states[-1].position, (40.0, 30.0, -15.0)) < 0.02


@pytest.mark.parametrize(
    ("step_m", "t90_s", "peak_mps", "overshoot_m"), [(10.0, 3.0, 5.2, 0.34), (30.0, None, 8.9, 1.2)]
)
def test_far_steps_are_those_of_px4_but_for_the_overshoot(
    step_m: float, t90_s: float | None, peak_mps: float, overshoot_m: float
) -> None:
    """Against what a PX4 with its own gains and MPC_XY_VEL_MAX of 12 m/s was seen to do.

    We arrive a little earlier, and differ on purpose at the end: PX4 passes the setpoint by 3 to
    4 %, we brake on a parabola and do not. A companion that keeps clear of walls by a distance
    should meet a simulated vehicle that misses them by its own fault alone.
    """
    physics, cascade = Physics(origin=SEA, start=HIGH), Cascade(ControllerLimits(speed_mps=12.0))
    flown(physics, cascade, TrajectorySetpoint(HIGH, STILL), 6.0)
    states = flown(physics, cascade, TrajectorySetpoint((step_m, 0.0, -10.0), STILL), 12.0)
    moved = [state.position[0] for state in states]
    assert max(math.hypot(*state.velocity) for state in states) == pytest.approx(peak_mps, rel=0.1)
    assert max(moved) - step_m < 0.1 * overshoot_m
    if t90_s is not None:
        arrived_s = DT * next(i for i, value in enumerate(moved) if value > 0.9 * step_m)
        assert arrived_s == pytest.approx(t90_s, rel=0.15)


def test_velocity_setpoints_reach_their_speed() -> None:
    physics, cascade = hovering()
    states = flown(physics, cascade, TrajectorySetpoint((None, None, -10.0), (2.0, -1.0, 0.0)), 8.0)
    assert states[-1].velocity == pytest.approx((2.0, -1.0, 0.0), abs=0.05)
    assert states[-1].position[2] == pytest.approx(-10.0, abs=0.02)


@pytest.mark.parametrize(
    ("wind", "turbulence_mps", "reach_m"),
    [pytest.param(STILL, 0.0, 0.03, marks=pytest.mark.long), ((3.0, 0.0, 0.0), 0.3, 0.08)],
)
def test_tracking(wind: Ned, turbulence_mps: float, reach_m: float) -> None:
    """A circle of 2 m at 1 m/s, entered smoothly, with feed-forward."""
    radius, rate, entry_s = 2.0, 0.5, 4.0

    def circle(t: float) -> TrajectorySetpoint:
        r = min(t / entry_s, 1.0)  # the turn rate follows a smooth step
        angle = rate * (entry_s * (r**6 - 3 * r**5 + 2.5 * r**4) + max(t - entry_s, 0.0))
        turn = rate * (6 * r**5 - 15 * r**4 + 10 * r**3)
        spin = rate * 30 * r**2 * (r - 1) ** 2 / entry_s
        s, c = math.sin(angle), math.cos(angle)
        return TrajectorySetpoint(
            (radius * s, radius * (1 - c), -10.0),
            (radius * turn * c, radius * turn * s, 0.0),
            (radius * (spin * c - turn**2 * s), radius * (spin * s + turn**2 * c), 0.0),
        )

    physics, cascade = hovering(wind, turbulence_mps)
    states = flown(physics, cascade, circle, 20.0)
    squares = [
        (wanted - real) ** 2
        for i, state in enumerate(states)
        for wanted, real in zip(circle((i + 1) * DT).position, state.position, strict=True)
        if wanted is not None
    ]
    assert math.sqrt(sum(squares) / len(states)) <= reach_m


@pytest.mark.parametrize("wind_mps", [pytest.param(4.0, marks=pytest.mark.long), 8.0])
def test_px4_s_own_quadrotor_holds_in_a_wind(wind_mps: float) -> None:
    """A PX4 came back from 1.0 m downwind within 10 s, in 7 m/s."""
    airframe = AIRFRAMES["px4_sih"]
    drag = airframe.linear_drag_n_per_mps
    physics = Physics(origin=SEA, start=HIGH, linear_drag_n_per_mps=drag)
    cascade = Cascade(gains=airframe.gains)
    hover = TrajectorySetpoint(HIGH, STILL)
    flown(physics, cascade, hover, 4.0)
    physics.set_wind((wind_mps, 0.0, 0.0))
    states = flown(physics, cascade, hover, 20.0)
    assert max(state.position[0] for state in states) == pytest.approx(0.36 * wind_mps, rel=0.1)
    assert abs(states[-1].position[0]) < 0.1


# Ground


def test_take_off_and_land() -> None:
    physics = Physics(origin=GlobalOrigin(47.4, 8.5, 488.0), yaw_rad=1.0)
    cascade = Cascade()
    cascade.reset(1.0)
    for _ in range(500):
        driven(physics, cascade.idle())
    state = physics.state
    assert state.is_on_ground
    assert math.hypot(*state.position) < 0.005
    assert state.motor_speed_radps == pytest.approx((60.0,) * 4, abs=1.0)

    climb = flown(physics, cascade, TrajectorySetpoint((0.0, 0.0, None), (0.0, 0.0, -1.0)), 3.0)
    assert not climb[-1].is_on_ground
    assert climb[-1].position[2] < -2.0
    assert climb[-1].velocity[2] == pytest.approx(-1.0, abs=0.1)  # thin air, still integrating
    assert euler_from_quaternion(climb[-1].attitude)[2] == pytest.approx(1.0, abs=0.01)

    sink = flown(physics, cascade, TrajectorySetpoint((0.0, 0.0, None), (0.0, 0.0, 0.7)), 5.0)
    assert sink[-1].is_on_ground
    assert max(state.velocity[2] for state in sink) < 0.8
    resting = physics.state.position
    for _ in range(1000):
        state = driven(physics, cascade.idle())
    assert state.is_on_ground
    assert math.dist(state.position, resting) < 0.005
    assert max(abs(angle) for angle in euler_from_quaternion(state.attitude)[:2]) < 0.002


def test_reset_forgets_the_last_flight() -> None:
    physics, used = hovering((4.0, 0.0, 0.0))
    fresh = Cascade()
    fresh.reset(0.5)
    used.reset(0.5)
    setpoint = TrajectorySetpoint(HIGH, STILL)
    state, dt_s = physics.state, CONTROL_S
    assert fresh.step(state, setpoint, dt_s) == used.step(state, setpoint, dt_s)


# Attitude

angles = st.floats(-3.1, 3.1)
tilts = st.floats(-0.9, 0.9)


@given(tilts, tilts, angles)
def test_attitude_from_thrust_points_the_thrust_axis(roll: float, pitch: float, yaw: float) -> None:
    w, x, y, z = quaternion_from_euler(roll, pitch, yaw)
    up = (-2 * (x * z + w * y), -2 * (y * z - w * x), -(1 - 2 * (x * x + y * y)))
    found = attitude_from_thrust(up, yaw)
    assert euler_from_quaternion(found) == pytest.approx((roll, pitch, yaw), abs=1e-9)


@given(tilts, tilts, angles, angles)
def test_tilt_and_heading_vanish_only_together(
    roll: float, pitch: float, yaw: float, turn: float
) -> None:
    q = quaternion_from_euler(roll, pitch, yaw)
    assert tilt_and_heading(q, q) == pytest.approx(STILL, abs=1e-12)
    opposite = (-q[0], -q[1], -q[2], -q[3])
    assert tilt_and_heading(q, opposite) == pytest.approx(STILL, abs=1e-12)
    level = quaternion_from_yaw(yaw)
    assert tilt_and_heading(level, quaternion_from_yaw(yaw + turn)) == pytest.approx(
        (0.0, 0.0, 2 * math.sin(turn / 2)), abs=1e-9
    )


@given(tilts, angles)
def test_a_pure_tilt_asks_for_no_turn(pitch: float, yaw: float) -> None:
    error = tilt_and_heading(quaternion_from_yaw(yaw), quaternion_from_euler(0.0, pitch, yaw))
    assert error == pytest.approx((0.0, 2 * math.sin(pitch / 2), 0.0), abs=1e-9)
