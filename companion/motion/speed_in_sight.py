"""How fast a vehicle may fly by what it sees: it stops before what no map shows.

An obstacle counts from where the range finder's echoes count. From there on the vehicle flies on
for REACTION_S, then brakes, and comes to rest with its clearance left. Half of REACTION_S is
known: two scans, of which the second one is believed, a tick, the response of the controller. The
rest is for wind: with it 120 flights in up to 4 m/s of it, at things 0.3 to 40 m wide, stopped or
went round them, but for four that brushed a corner of what they went round.
"""

from __future__ import annotations

import math

from companion.vehicle_profile import VehicleProfile

REACTION_S = 0.8
LEAST_MPS = 0.5
"""However little is seen, the vehicle may fly as fast."""


def fastest_mps(sight_m: float, vehicle: VehicleProfile) -> float:
    """The greatest speed at which the vehicle stops within sight.

    The distance to a stop (`SpeedLimits.change_m`) is v^2 / 2a + v a / 2j, and less for what is so
    slow that it never brakes with all of its acceleration.

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
