"""The mixer: motor commands for a collective thrust and torques.

In: thrust in N and torques in N m. Out: four motor commands for PX4's quad-x and whether they
fall short. When the motors cannot do everything, roll and pitch come first, then thrust, and yaw
loses first: a quadrotor with the wrong heading still flies (PX4, ControlAllocation, sequential
desaturation). The commands are corrected for the battery's voltage, as PX4's MC_BAT_SCALE_EN does.

The constants are those of `quadrotor.xml`, at sea level, as the autopilot is configured with them;
the tests hold one against the other.
"""

from __future__ import annotations

import math
from typing import NamedTuple

MASS_KG = 1.5
HUB_M = 0.225 / math.sqrt(2)  # distance of a hub from the roll and from the pitch axis
THRUST_CONSTANT = 1.2916e-5  # N / (rad/s)^2
TORQUE_PER_THRUST_M = 2.3495e-7 / 1.2916e-5  # k_Q / k_T
SPEED_CONSTANT = 950.0 / 16.8  # rad/s per volt at full command
IDLE_SPEED = 60.0  # rad/s
MAX_SPEED = 850.0  # rad/s, kept below the 950 that only a full battery gives

MIN_THRUST_N = THRUST_CONSTANT * IDLE_SPEED**2
MAX_THRUST_N = THRUST_CONSTANT * MAX_SPEED**2
IDLE_COMMAND = IDLE_SPEED / (SPEED_CONSTANT * 16.8)
_COMMAND_VOLTS = 1 / (SPEED_CONSTANT * math.sqrt(THRUST_CONSTANT))  # V per sqrt(N)

Motors = tuple[float, float, float, float]
"""Motor commands 0 to 1: front right, rear left, front left, rear right."""


class Mix(NamedTuple):
    """Motor commands 0 to 1 and what they could not deliver."""

    motors: Motors
    is_tilt_limited: bool
    is_yaw_limited: bool


def mix(thrust_n: float, roll_nm: float, pitch_nm: float, yaw_nm: float, voltage_v: float) -> Mix:
    """Motor commands for a thrust along -z and torques about body x, y, z.

    >>> hover = mix(1.5 * 9.81, 0.0, 0.0, 0.0, 16.0)
    >>> [round(command, 3) for command in hover.motors], hover.is_yaw_limited
    ([0.59, 0.59, 0.59, 0.59], False)
    """
    roll, pitch = roll_nm / (4 * HUB_M), pitch_nm / (4 * HUB_M)
    # Front right, rear left, front left, rear right.
    a, b = pitch - roll, pitch + roll
    reach = max(abs(a), abs(b))
    most = (MAX_THRUST_N - MIN_THRUST_N) / 2
    is_tilt_limited = reach > most
    if is_tilt_limited:
        a, b, reach = a * most / reach, b * most / reach, most
    base = min(max(thrust_n / 4, MIN_THRUST_N + reach), MAX_THRUST_N - reach)
    yaw = yaw_nm / (4 * TORQUE_PER_THRUST_M)
    # Rotors 1 and 2 gain what 3 and 4 lose.
    if yaw >= 0:
        room = min(MAX_THRUST_N - base - abs(a), base - abs(b) - MIN_THRUST_N)
    else:
        room = min(MAX_THRUST_N - base - abs(b), base - abs(a) - MIN_THRUST_N)
    is_yaw_limited = abs(yaw) > room
    if is_yaw_limited:
        yaw = math.copysign(max(room, 0.0), yaw)
    scale, sqrt = _COMMAND_VOLTS / voltage_v, math.sqrt
    m_1 = sqrt(base + a + yaw) * scale
    m_2 = sqrt(base - a + yaw) * scale
    m_3 = sqrt(base + b - yaw) * scale
    m_4 = sqrt(base - b - yaw) * scale
    if max(m_1, m_2, m_3, m_4) > 1.0:  # the battery cannot give that any more
        m_1, m_2, m_3, m_4 = min(1.0, m_1), min(1.0, m_2), min(1.0, m_3), min(1.0, m_4)
    return Mix((m_1, m_2, m_3, m_4), is_tilt_limited, is_yaw_limited)
