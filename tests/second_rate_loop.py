"""The rate loop and the mixer once more: an oracle for `rate_control.xml`.

Written from the same controller diagrams, as one would in a program. The derivative is that of two
rates, as an autopilot has it, where the file takes the angular acceleration of the physics.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from second_model import HUB, K_Q, K_T, SPEED_PER_VOLT

from sitl.flight.physics import RateSetpoint
from sitl.flight.rotors import MAX_THRUST_N, MIN_THRUST_N, Motors

GAIN_P, GAIN_I, GAIN_D = (0.35, 0.37, 0.25), (0.5, 0.5, 0.15), (0.006, 0.006, 0.0)
"""Of roll, pitch and yaw."""
MOST_NM = 0.3  # of an integral

Vector = tuple[float, float, float]


class Mix(NamedTuple):
    """Motor commands, and whether they fall short."""

    motors: Motors
    is_tilt_limited: bool
    is_yaw_limited: bool


def mix(thrust_n: float, roll_nm: float, pitch_nm: float, yaw_nm: float, voltage_v: float) -> Mix:
    """Motor commands for a thrust along -z and torques about body x, y, z."""
    roll, pitch = roll_nm / (4 * HUB), pitch_nm / (4 * HUB)
    right, left = pitch - roll, pitch + roll
    reach, most = max(abs(right), abs(left)), (MAX_THRUST_N - MIN_THRUST_N) / 2
    is_tilt_limited = reach > most
    if is_tilt_limited:
        right, left, reach = right * most / reach, left * most / reach, most
    base = min(max(thrust_n / 4, MIN_THRUST_N + reach), MAX_THRUST_N - reach)
    yaw = yaw_nm * K_T / (4 * K_Q)
    gains, loses = (right, left) if yaw >= 0 else (left, right)
    room = min(MAX_THRUST_N - base - abs(gains), base - abs(loses) - MIN_THRUST_N)
    is_yaw_limited = abs(yaw) > room
    if is_yaw_limited:
        yaw = math.copysign(max(room, 0.0), yaw)
    thrusts = base + right + yaw, base - right + yaw, base + left - yaw, base - left - yaw
    scale = 1 / (SPEED_PER_VOLT * math.sqrt(K_T) * voltage_v)
    m_1, m_2, m_3, m_4 = (min(1.0, scale * math.sqrt(thrust)) for thrust in thrusts)
    return Mix((m_1, m_2, m_3, m_4), is_tilt_limited, is_yaw_limited)


class SecondRateLoop:
    """Rate PID and mixer; call `step` with each state."""

    def __init__(self) -> None:
        self._integral = [0.0, 0.0, 0.0]
        self._last: Vector = (0.0, 0.0, 0.0)

    def step(self, rates: Vector, voltage_v: float, wanted: RateSetpoint, dt_s: float) -> Motors:
        """Motor commands towards the wanted rates."""
        errors = [asked - rate for asked, rate in zip(wanted.rates, rates, strict=True)]
        slopes = [(rate - last) / dt_s for rate, last in zip(rates, self._last, strict=True)]
        roll, pitch, yaw = (
            GAIN_P[i] * errors[i] + self._integral[i] - GAIN_D[i] * slopes[i] for i in range(3)
        )
        self._last = rates
        mixed = mix(wanted.thrust_n, roll, pitch, yaw, voltage_v)
        stuck = (mixed.is_tilt_limited, mixed.is_tilt_limited, mixed.is_yaw_limited)
        for i in range(3):
            if not stuck[i]:
                integral = self._integral[i] + GAIN_I[i] * errors[i] * dt_s
                self._integral[i] = min(MOST_NM, max(-MOST_NM, integral))
        return mixed.motors
