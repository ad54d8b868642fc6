"""PX4's multicopter cascade: from a setpoint to body rates and a thrust.

    position P -> velocity PI -> attitude P -> rate PID -> mixer
    |---------------- 50 Hz --------------|    |- every step -|
                    here                       rate_control.xml

Position and velocity errors give an acceleration setpoint, this gives a thrust vector, and that
gives an attitude (first the direction of thrust, then heading) and a thrust. When thrust is short,
height has priority over horizontal motion. Integrators stop while their loop is limited.

Source: PX4's controller diagrams and mc_pos_control, mc_att_control, mc_rate_control.
Unlike PX4, gains are in SI (N m, m/s^2), and the speed towards a far position follows a braking
parabola, so that a distant setpoint causes no overshoot (PX4: 0.3 m of 10 m, 1.2 m of 30 m).
Otherwise, speeds and times of such steps are PX4's.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.geometry import GRAVITY_MPS2, Quaternion, quaternion_from_yaw, wrap_angle
from sitl.flight.attitude import attitude_from_thrust, tilt_and_heading
from sitl.flight.physics import FlightState, RateSetpoint
from sitl.flight.rotors import IDLE_COMMAND, MASS_KG, MAX_THRUST_N, MIN_THRUST_N, Motors

VERTICAL_P, CLIMB_P, CLIMB_I = 2.0, 6.0, 2.5  # 1/s, 1/s, 1/s^2
ATTITUDE_P = (7.0, 7.0, 3.0)  # 1/s

CONTROL_STEPS = 5  # physics steps for one step of the loops here
BRAKING_SHARE = 0.5  # of the acceleration limit, to brake before a far position
FADE_MPS = 0.2  # velocity errors above this count less and less for the integrals
MAX_INTEGRAL_MPS2 = 4.0  # where errors fade
LEAST_LIFT_MPS2, MOST_LIFT_MPS2 = 4 * MIN_THRUST_N / MASS_KG, 4 * MAX_THRUST_N / MASS_KG

Vector = tuple[float, float, float]
Maybe = tuple[float | None, float | None, float | None]


@dataclass(frozen=True, slots=True)
class ControllerLimits:
    """The limits of the position loops' outputs."""

    speed_mps: float = 5.0
    climb_mps: float = 3.0
    descent_mps: float = 1.5
    acceleration_mps2: float = 5.0
    yaw_rate_radps: float = 1.5


@dataclass(frozen=True, slots=True)
class HorizontalGains:
    """The horizontal position loops: PX4's MPC_XY_P, _VEL_P_ACC, _VEL_I_ACC and MPC_TILTMAX_AIR.

    Attributes:
        position_p: 1/s.
        velocity_p: 1/s.
        velocity_i: 1/s^2.
        tilt_rad: the largest tilt.
        is_gentle: whether the loops obey the acceleration limit, and integrate large errors less.
            PX4's do neither: they lean into any wind that they can hold against.
    """

    position_p: float = 1.6
    velocity_p: float = 4.0
    velocity_i: float = 1.2
    tilt_rad: float = 0.6
    is_gentle: bool = True


OWN_GAINS = HorizontalGains()
"""The gains of the vehicle in quadrotor.xml."""


@dataclass(frozen=True, slots=True)
class TrajectorySetpoint:
    """PX4's trajectory_setpoint; None is "not controlled", as NaN there.

    Attributes:
        position: local NED, metres.
        velocity: NED, m/s: feed-forward where a position is given, setpoint where none is.
        acceleration: NED, m/s^2: feed-forward, or the setpoint where neither is given.
        yaw_rad: heading; None holds the last one.
        yaw_rate_radps: feed-forward with a heading, turns the held heading without one.
        speed_mps: largest horizontal speed; None is as fast as the limits allow.
    """

    position: Maybe
    velocity: Maybe
    acceleration: Vector = (0.0, 0.0, 0.0)
    yaw_rad: float | None = None
    yaw_rate_radps: float | None = None
    speed_mps: float | None = None


class VelocityLoop:
    """Position P and velocity PI: from a setpoint to a specific thrust vector in NED, m/s^2."""

    def __init__(self, limits: ControllerLimits, gains: HorizontalGains) -> None:
        self._limits, self._gains = limits, gains
        self.reset()

    def reset(self) -> None:
        """Clears the integrals."""
        self._integral: Vector = (0.0, 0.0, 0.0)

    def reset_push(self) -> None:
        """Clears the horizontal integrals."""
        self._integral = (0.0, 0.0, self._integral[2])

    def step(self, state: FlightState, setpoint: TrajectorySetpoint, dt_s: float) -> Vector:
        """The thrust per mass towards the setpoint, NED; at rest (0, 0, -g)."""
        e_n, e_e, e_d = self._velocity_error(state, setpoint)
        i_n, i_e, i_d = self._integral
        a_n, a_e, a_d = setpoint.acceleration
        gains = self._gains
        north = a_n + gains.velocity_p * e_n + i_n
        east = a_e + gains.velocity_p * e_e + i_e
        down = a_d + CLIMB_P * e_d + i_d
        limit = self._limits.acceleration_mps2
        lift = _clamp(_clamp(down, -limit, limit) - GRAVITY_MPS2, -MOST_LIFT_MPS2, -LEAST_LIFT_MPS2)
        is_lift_limited = (down - GRAVITY_MPS2 - lift) * e_d > 0
        # Height first: horizontal thrust gets what tilt and motors leave.
        most = min(
            limit if gains.is_gentle else math.inf,
            -lift * math.tan(gains.tilt_rad),
            math.sqrt(max(0.0, MOST_LIFT_MPS2**2 - lift**2)),
        )
        wanted = math.hypot(north, east)
        is_push_limited = wanted > most and north * e_n + east * e_e > 0
        if wanted > most:
            north, east = north * most / wanted, east * most / wanted
        if not is_push_limited:
            if gains.is_gentle:
                e_n, e_e, most = _fade(e_n), _fade(e_e), MAX_INTEGRAL_MPS2
            i_n = _clamp(i_n + gains.velocity_i * e_n * dt_s, -most, most)
            i_e = _clamp(i_e + gains.velocity_i * e_e * dt_s, -most, most)
        if not is_lift_limited:
            i_d += CLIMB_I * _fade(e_d) * dt_s
        self._integral = (i_n, i_e, _clamp(i_d, -MAX_INTEGRAL_MPS2, MAX_INTEGRAL_MPS2))
        return (north, east, lift)

    def _velocity_error(self, state: FlightState, setpoint: TrajectorySetpoint) -> Vector:
        limits = self._limits
        braking = BRAKING_SHARE * limits.acceleration_mps2
        p_n, p_e, p_d = setpoint.position
        v_n, v_e, v_d = setpoint.velocity
        n, e, d = state.position
        to_n = 0.0 if p_n is None else p_n - n
        to_e = 0.0 if p_e is None else p_e - e
        to_d = 0.0 if p_d is None else p_d - d
        far = math.hypot(to_n, to_e)
        gain = _approach_speed(far, self._gains.position_p, braking) / far if far > 0 else 0.0
        climb = math.copysign(_approach_speed(abs(to_d), VERTICAL_P, braking), to_d)
        north = gain * to_n + (v_n or 0.0)
        east = gain * to_e + (v_e or 0.0)
        down = _clamp(climb + (v_d or 0.0), -limits.climb_mps, limits.descent_mps)
        speed, most = math.hypot(north, east), limits.speed_mps
        if setpoint.speed_mps is not None:
            most = min(most, setpoint.speed_mps)
        if speed > most:
            north, east = north * most / speed, east * most / speed
        now_n, now_e, now_d = state.velocity
        return (
            0.0 if p_n is None and v_n is None else north - now_n,
            0.0 if p_e is None and v_e is None else east - now_e,
            0.0 if p_d is None and v_d is None else down - now_d,
        )


class Cascade:
    """The whole cascade of one vehicle; call `reset` when arming.

    Attributes:
        attitude: setpoint, body to NED.
        thrust_n: setpoint, N.
    """

    def __init__(
        self,
        limits: ControllerLimits = ControllerLimits(),
        gains: HorizontalGains = OWN_GAINS,
    ) -> None:
        self._limits = limits
        self._velocity_loop = VelocityLoop(limits, gains)
        self.reset(0.0)

    def reset(self, yaw_rad: float) -> None:
        """Clears the integrators; holds this heading until one is commanded."""
        self._velocity_loop.reset()
        self._yaw = yaw_rad
        self._yaw_rate = 0.0
        self.attitude = quaternion_from_yaw(yaw_rad)
        self.thrust_n = MASS_KG * GRAVITY_MPS2

    def idle(self) -> Motors:
        """Motor commands of an armed vehicle that stands; no integral winds up meanwhile."""
        self.reset(self._yaw)
        return (IDLE_COMMAND,) * 4

    def step(self, state: FlightState, setpoint: TrajectorySetpoint, dt_s: float) -> RateSetpoint:
        """The rate setpoint that leads towards the setpoint; call it at 50 Hz."""
        self._step_position(state, setpoint, dt_s)
        return RateSetpoint(self.thrust_n, self._wanted_rates(state.attitude))

    def touch_down(
        self, state: FlightState, setpoint: TrajectorySetpoint, dt_s: float
    ) -> RateSetpoint:
        """The same on the ground, which holds the vehicle: level, whatever the wind.

        A vehicle that leans when its motors idle would tip over.
        """
        self._velocity_loop.reset_push()
        vertical = TrajectorySetpoint(
            position=(None, None, setpoint.position[2]),
            velocity=(None, None, setpoint.velocity[2]),
            acceleration=(0.0, 0.0, setpoint.acceleration[2]),
            yaw_rad=setpoint.yaw_rad,
            yaw_rate_radps=setpoint.yaw_rate_radps,
        )
        return self.step(state, vertical, dt_s)

    def _wanted_rates(self, q: Quaternion) -> Vector:
        tilt_x, tilt_y, heading = tilt_and_heading(q, self.attitude)
        # A turn about NED down has components on all three body axes.
        w, x, y, z = q
        turn, limit = self._yaw_rate, self._limits.yaw_rate_radps
        yaw = ATTITUDE_P[2] * heading + (1 - 2 * (x * x + y * y)) * turn
        return (
            ATTITUDE_P[0] * tilt_x + 2 * (x * z - w * y) * turn,
            ATTITUDE_P[1] * tilt_y + 2 * (y * z + w * x) * turn,
            _clamp(yaw, -limit, limit),
        )

    def _step_position(self, state: FlightState, setpoint: TrajectorySetpoint, dt_s: float) -> None:
        limit = self._limits.yaw_rate_radps
        self._yaw_rate = _clamp(setpoint.yaw_rate_radps or 0.0, -limit, limit)
        if setpoint.yaw_rad is not None:
            self._yaw = setpoint.yaw_rad
        else:
            self._yaw = wrap_angle(self._yaw + self._yaw_rate * dt_s)
        thrust = self._velocity_loop.step(state, setpoint, dt_s)
        self.attitude = attitude_from_thrust(thrust, self._yaw)
        # Only the part of the wanted thrust along the present body axis is commanded, so that
        # height does not jump while the vehicle is still turning.
        w, x, y, z = state.attitude
        down = (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y))
        along = -sum(t * d for t, d in zip(thrust, down, strict=True))
        self.thrust_n = MASS_KG * max(along, 0.0)


def _approach_speed(distance_m: float, gain: float, braking_mps2: float) -> float:
    """Speed towards a position: proportional when near, on v^2 = 2 a s when far; smooth between."""
    near = braking_mps2 / gain**2
    if distance_m <= near:
        return gain * distance_m
    return math.sqrt(2 * braking_mps2 * (distance_m - near / 2))


def _fade(error: float) -> float:
    """A velocity error as the integrals take it: large errors, from setpoint steps, are reduced.

    A constant disturbance appears as a small error and is integrated away. The large error at the
    start of a step would leave a tail of seconds (PX4's rate loop fades its integral likewise).
    """
    return error / (1 + (error / FADE_MPS) ** 2)


def _clamp(value: float, low: float, high: float) -> float:
    return low if value < low else high if value > high else value
