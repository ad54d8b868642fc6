"""How fast the time of a trajectory runs, for a vehicle that falls behind its setpoint.

The trajectory is slowed for the vehicle, and waits for it, so that its setpoint does not run away.
At the speed V of the trajectory

    rate = (1 - b) v / V + b (WAITS - s) / (WAITS - FOLLOWS),    b = min(1, DAMPED_MPS / V)

with the vehicle's speed v along the trajectory, and its distance s behind it, as a share of the
gate's greatest distance. A slow trajectory follows the distance alone. By this a fast one would
swing: in the 0.1 s until an effect is measured it crosses the range in which it is slowed. So it
follows the vehicle's speed in part, and its speed answers the distance with the gain of a
trajectory at DAMPED_MPS. A vehicle that flies at the speed of its setpoint is equally far behind at
each rate, whatever V is.

Source: scaling of the time along a given path, Biagiotti and Melchiorri, Trajectory Planning for
Automatic Machines and Robots, 2008, chapter 9; the feedback is our own.
"""

from __future__ import annotations

import math

from companion.geometry import Ned

FOLLOWS_SHARE, WAITS_SHARE = 0.4, 0.7
"""Shares of the gate's greatest distance: when a vehicle is so far behind its trajectory, the
trajectory is slowed, and waits for it."""
DAMPED_MPS = 3.0
"""The gain is 6.7 /s at this speed. Such a loop is stable up to 16 /s if its delay is 0.1 s, and up
to 10 /s if it is 0.16 s."""


def behind_m(away: Ned, velocity: Ned) -> float:
    """How far a vehicle is behind its setpoint, or beside it; not how far it is ahead.

    >>> behind_m((0.0, 0.5, 0.0), (0.0, 5.0, 0.0)), behind_m((3.0, -4.0, 0.0), (0.0, 5.0, 0.0))
    (0.5, 3.0)

    Args:
        away: from the vehicle to its setpoint.
        velocity: of the setpoint.
    """
    ahead_m = max(0.0, -along(away, velocity))
    return math.sqrt(max(0.0, math.hypot(*away) ** 2 - ahead_m**2))


def time_rate(behind_share: float, speed_mps: float, vehicle_mps: float) -> float:
    """How fast the time of a trajectory runs, from 0 to 1.

    >>> time_rate(0.3, 2.0, 2.0), time_rate(0.55, 2.0, 1.0), time_rate(0.8, 2.0, 0.0)
    (1.0, 0.5, 0.0)
    >>> time_rate(0.55, 10.0, 10.0), time_rate(0.55, 10.0, 5.0)
    (0.85, 0.5)

    Args:
        behind_share: how far the vehicle is behind, as a share of the gate's greatest distance.
        speed_mps: of the trajectory.
        vehicle_mps: speed of the vehicle along the trajectory.
    """
    rate = (WAITS_SHARE - behind_share) / (WAITS_SHARE - FOLLOWS_SHARE)
    if speed_mps > DAMPED_MPS:
        share = DAMPED_MPS / speed_mps
        rate = (1.0 - share) * vehicle_mps / speed_mps + share * rate
    return round(min(max(rate, 0.0), 1.0), 9)


def along(vector: Ned, velocity: Ned) -> float:
    """The part of a vector that points along a velocity.

    >>> along((3.0, 4.0, 0.0), (0.0, 2.0, 0.0))
    4.0
    """
    speed_mps = math.hypot(*velocity)
    if speed_mps == 0.0:
        return 0.0
    return sum(a * b for a, b in zip(vector, velocity, strict=True)) / speed_mps
