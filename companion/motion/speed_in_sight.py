"""The greatest speed from which a vehicle can stop before obstacles that no map shows.

An obstacle is noticed where the range finder's echoes begin to count. From there the vehicle flies
on for REACTION_S, then brakes, and comes to rest with its clearance left. Half of REACTION_S is
known: two scans, the second of which is believed, a tick, and the response of the controller. The
rest is for wind. With it, in 120 flights in wind of up to 4 m/s, at things 0.3 to 40 m wide,
vehicles stopped or flew around them; only four brushed a corner while flying around.
"""

from __future__ import annotations

import math

from companion.vehicle_profile import VehicleProfile

REACTION_S = 0.8
LEAST_MPS = 0.5
"""The vehicle may always fly at this speed, however little it sees."""


def fastest_mps(sight_m: float, vehicle: VehicleProfile) -> float:
    """The greatest speed at which the vehicle stops within sight.

    The distance to a stop (`SpeedLimits.change_m`) is v^2 / 2a + v a / 2j; it is less at speeds so
    low that the full acceleration is never reached.

    >>> round(fastest_mps(8.0, VehicleProfile()), 1)
    4.6

    Args:
        sight_m: how far the vehicle sees.
        vehicle: how it brakes, and what it keeps from obstacles.
    """
    braking_mps2 = vehicle.braking_mps2
    late_mps = braking_mps2 * (REACTION_S + braking_mps2 / (2 * vehicle.jerk_mps3))
    room_m = max(0.0, sight_m - vehicle.clearance_m)
    return max(LEAST_MPS, math.sqrt(late_mps**2 + 2 * braking_mps2 * room_m) - late_mps)
