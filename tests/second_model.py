"""A second, independent model of the airframe: the vehicle flies as its equations say.

An oracle for `sitl.flight.physics`: the equations of quadrotor.xml written once more, in numpy,
integrated by Runge-Kutta 4 instead of JSBSim's Adams-Bashforth. A command changes linearly through
a step, as the bilinear lag filters of JSBSim take it.

    rotor     d omega/dt = (k_V u V - omega) / 20 ms
    thrust    T = sigma (k_T omega^2 G - k_i omega V_axial),  k_i = k_T / (0.40 R)
    ground    G = 1 / (1 - (R / 4z)^2)                        (Cheeseman and Bennett)
    drag      -(c sigma sum(omega) + rho/2 |V| C_d A) V in the rotor plane, without c along z
    torque    hub arms x T, sigma k_Q omega^2 and I_r d omega/dt about z, -w x h of the rotors
    battery   4 OCV(charge) - R0 I - R1 i_rc,  I = I_av + sigma sum(k_Q omega^3) / (eta V)

The Earth is flat and turns: gravity is the felt one (Somigliana, free-air gradient), moving
vehicles feel Coriolis' force, and a body keeps its attitude among the stars. Left out: contact,
turbulence. Coefficients: C_T 0.100, C_P 0.045 of a propeller of 10 inches.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from companion.geometry import Ned
from sitl.flight.physics import FlightState
from sitl.flight.rotors import Motors

Array = NDArray[np.float64]

RHO, DIAMETER = 1.225, 0.254
RADIUS = DIAMETER / 2
MASS = 1.5
INERTIA = np.array((0.0160, 0.0170, 0.0290))
K_T = 0.100 * RHO * DIAMETER**4 / (2 * math.pi) ** 2
K_Q = 0.045 * RHO * DIAMETER**5 / (2 * math.pi) ** 3
K_I = K_T / (0.40 * RADIUS)
ROTOR_DRAG, ROTOR_INERTIA, LAG_S = 4.75e-5, 6.0e-5, 0.020
DRAG_AREA = np.array((0.016, 0.016, 0.030))
HUB = 0.225 / math.sqrt(2)
FORWARD, RIGHT = HUB * np.array((1, -1, 1, -1)), HUB * np.array((1, -1, -1, 1))
SPIN = np.array((1, 1, -1, -1))  # the torque about z on the body: drag of counter-clockwise rotors
SPEED_PER_VOLT, MAX_SPEED = 950 / 16.8, 950.0
CAPACITY_AS, AVIONICS_A, EFFICIENCY = 3600 * 5.0, 0.6, 0.80
R0, R1, RC_S = 0.016, 0.010, 20.0
CHARGES = (0.0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
CELL_V = (3.27, 3.55, 3.68, 3.74, 3.77, 3.79, 3.83, 3.88, 3.96, 4.04, 4.12, 4.20)
STANDING_M = 0.12 - MASS * 9.81 / 6000  # of the centre of mass, on four springs of 1500 N/m
EARTH_RATE = 7.292115e-5  # rad/s


@dataclass
class SecondModel:
    """One vehicle; `state` as that of Physics, the specific force is not computed.

    Args:
        state: to start from.
        latitude_deg: of the place.
        ground_m: its height above the sea.
        wind: steady, NED.
        rc_current_a: in the battery's RC pair at the start.
        motors: the commands before the first step.
    """

    state: FlightState
    latitude_deg: float
    ground_m: float = 0.0
    wind: Ned = (0.0, 0.0, 0.0)
    rc_current_a: float = 0.0
    motors: Motors = (0.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        s = self.state
        self._y = np.array(
            [
                *(*s.position, *s.velocity, *s.attitude, *s.rates),
                *(*s.motor_speed_radps, s.charge, self.rc_current_a),
            ]
        )
        self._u = np.array(self.motors)
        latitude_rad = math.radians(self.latitude_deg)
        self._earth = EARTH_RATE * np.array((math.cos(latitude_rad), 0, -math.sin(latitude_rad)))
        self._gravity = _felt_gravity(self.latitude_deg)

    def step(self, motors: Motors, dt_s: float, *, is_draining: bool = True) -> FlightState:
        """Move on by one step with these motor commands."""
        before, after = self._u, np.array(motors)
        middle, y, h = (before + after) / 2, self._y, dt_s

        def slope(y: Array, u: Array) -> Array:
            return self._slope(y, u, is_draining)

        k1 = slope(y, before)
        k2 = slope(y + h / 2 * k1, middle)
        k3 = slope(y + h / 2 * k2, middle)
        k4 = slope(y + h * k3, after)
        y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        y[6:10] /= np.linalg.norm(y[6:10])
        self._y, self._u = y, after
        voltage, current = self._battery(y, self._density(y))
        values = y.tolist()
        self.state = FlightState(
            self.state.time_s + dt_s,
            (values[0], values[1], values[2]),
            (values[3], values[4], values[5]),
            (values[6], values[7], values[8], values[9]),
            (math.nan, math.nan, math.nan),
            (values[10], values[11], values[12]),
            (math.nan, math.nan, math.nan),
            motors,
            (values[13], values[14], values[15], values[16]),
            voltage,
            current,
            values[17],
            False,
        )
        return self.state

    def _density(self, y: Array) -> float:
        """Relative to sea level, in the International Standard Atmosphere."""
        return float((1 - 0.0065 * (self.ground_m - y[2]) / 288.15) ** 4.25588)

    def _battery(self, y: Array, sigma: float) -> tuple[float, float]:
        """Voltage and current: V = E - R0 (I_av + P / V), solved for V."""
        power = sigma * K_Q * float((y[13:17] ** 3).sum()) / EFFICIENCY
        e = 4 * float(np.interp(y[17], CHARGES, CELL_V)) - R1 * y[18] - R0 * AVIONICS_A
        voltage = (e + math.sqrt(e * e - 4 * R0 * power)) / 2
        return voltage, AVIONICS_A + power / voltage

    def _slope(self, y: Array, u: Array, is_draining: bool) -> Array:
        v, q, w, omega = y[3:6], y[6:10], y[10:13], y[13:17]
        turn = _matrix(q)  # body to NED
        sigma = self._density(y)
        voltage, current = self._battery(y, sigma)
        omega_dot = (np.clip(SPEED_PER_VOLT * voltage * u, 0, MAX_SPEED) - omega) / LAG_S

        air = turn.T @ (v - np.array(self.wind))
        axial = -(air[2] + w[0] * RIGHT - w[1] * FORWARD)  # upwards at each hub
        ground = 1 / (1 - (RADIUS / (4 * max(STANDING_M - y[2], RADIUS / 2))) ** 2)
        thrust = sigma * (K_T * omega**2 * ground - K_I * omega * axial)
        in_plane = ROTOR_DRAG * sigma * omega.sum() * np.array((1, 1, 0))
        force = -(in_plane + RHO / 2 * sigma * np.linalg.norm(air) * DRAG_AREA) * air
        force[2] -= thrust.sum()

        momentum = np.array((0, 0, -ROTOR_INERTIA * (SPIN @ omega)))
        moment = np.array(
            (
                -(RIGHT @ thrust),
                FORWARD @ thrust,
                SPIN @ (sigma * K_Q * omega**2 + ROTOR_INERTIA * omega_dot),
            )
        ) - np.cross(w, momentum)

        earth = turn.T @ self._earth
        among_stars = w + earth
        w_dot = (moment - np.cross(among_stars, INERTIA * among_stars)) / INERTIA
        gravity = np.array((0, 0, self._gravity - 3.086e-6 * (self.ground_m - y[2])))
        return np.concatenate(
            (
                v,
                turn @ force / MASS + gravity - 2 * np.cross(self._earth, v),
                _quaternion_slope(q, w),
                w_dot + np.cross(w, earth),
                omega_dot,
                (-current / CAPACITY_AS if is_draining else 0.0, (current - y[18]) / RC_S),
            )
        )


def _felt_gravity(latitude_deg: float) -> float:
    """Somigliana's formula on the ellipsoid of WGS 84."""
    s = math.sin(math.radians(latitude_deg)) ** 2
    return 9.7803253359 * (1 + 0.00193185265241 * s) / math.sqrt(1 - 0.00669437999013 * s)


def _matrix(q: Array) -> Array:
    w, x, y, z = q / np.linalg.norm(q)
    return np.array(
        (
            (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
        )
    )


def _quaternion_slope(q: Array, rates: Array) -> Array:
    (w, x, y, z), (p, q_, r) = q, rates
    w_dot = -x * p - y * q_ - z * r
    x_dot = w * p + y * r - z * q_
    y_dot = w * q_ - x * r + z * p
    z_dot = w * r + x * q_ - y * p
    return np.array((w_dot, x_dot, y_dot, z_dot)) / 2
