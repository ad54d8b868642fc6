"""A reboot of the autopilot: what it keeps and what it loses.

PX4 keeps its parameters, the mission, the fence and rally points. All else is as at the first
start: disarmed, in hold, clock at 0, home and stream rates reset. In the air this stops the motors,
and the vehicle falls. Some vehicles have a second processor at the motors, which continues to fly
and arms the main one again (PX4's in-air restart with its IO board): `recovers`.

Source: PX4 1.16, user guide, parameters and missions; src/drivers/px4io for the in-air restart.
Left out: the origin of the local frame. PX4 sets a new one where it boots; here it stays.
"""

from __future__ import annotations

from sitl.autopilot.autopilot import Autopilot
from sitl.flight.controllers import HorizontalGains
from sitl.flight.physics import FlightState


def rebooted(
    before: Autopilot, state: FlightState, gains: HorizontalGains, *, recovers: bool
) -> Autopilot:
    """The autopilot after a reboot.

    Args:
        before: the autopilot before.
        state: the present estimate.
        gains: the gains of the horizontal position loops.
        recovers: whether an armed vehicle stays armed and holds its place.
    """
    after = Autopilot(before.parameters, state, gains)
    before.mission.note_disarming()
    after.mission, after.fence = before.mission, before.fence
    after.safe_points = before.safe_points
    after.is_crashed = before.is_crashed
    after.health.knows_battery = before.health.knows_battery
    after.refuse_arming(before.arming_refusal)
    if recovers and before.is_armed:
        after.is_armed, after.control = True, before.control
        after.flights.arm(state.time_s)
        if not after.is_landed:
            after.flights.take_off(state.time_s)
    return after
