"""A reboot of the autopilot: what it still knows afterwards, and what it has lost.

PX4 keeps its parameters, the mission, the fence and rally points in its memory. All else begins
anew: disarmed, in hold, the clock at 0, home and rates of streams as at first. In the air that
stops the motors, and the vehicle falls. Some vehicles have a processor at the motors that flies on
and has the main one armed again (PX4's in-air restart with its IO board): `recovers`.

Source: PX4 1.16, user guide, parameters and missions; src/drivers/px4io for the in-air restart.
Left out: the origin of the local frame, which a PX4 lays anew where it boots; here it stays.
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
        before: as it was.
        state: as estimated now.
        gains: of the horizontal position loops.
        recovers: a vehicle that is armed stays so, and holds its place.
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
