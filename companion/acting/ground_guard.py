"""Keeps the vehicle off what is below it, by a range finder that looks down.

An altitude may be off: a PX4 v1.15.4 on its own simulator sank to the ground in 4 to 20 s, level by
its own altitude. So what is below the vehicle is kept as far away as routes keep what is
beside it, though no further than half of the height that is flown; a setpoint that would lead
nearer is lifted, as far as the altitude band has room, and what is flown goes on so much higher.
The way down to a marker is not touched, nor are modes of the autopilot (take-off, landing, hold):
those are its own. While the range finder is silent, a setpoint that was lifted stays so.
"""

from __future__ import annotations

import math
from dataclasses import replace

from companion.flight_events.skills import GroundNear
from companion.motion.layered_routes import LayeredRoutes
from companion.vehicle.port import Mode, Setpoint, VehicleState
from companion.vehicle_profile import VehicleProfile

SHARE = 0.5
"""Of the height above what the map has below: so much less is still taken for an error."""
RISE_M = 0.5
"""A setpoint is lifted by so much more than is missing, as a vehicle that sinks goes on sinking."""
CLEAR_AGAIN_M = 0.2
"""A setpoint with so much more than is asked for is sent as it is again."""
CARROT_SHARE = 0.95
"""Of the carrot, in which the gate lets a setpoint out."""


class GroundGuard:
    """Of one flight.

    Args:
        routes: know what the map has below.
        profile: of the vehicle.
        highest_m: the upper end of the altitude band.

    Attributes:
        lift_m: how much higher the last setpoint was sent.
    """

    def __init__(self, routes: LayeredRoutes, profile: VehicleProfile, highest_m: float) -> None:
        self._routes, self._profile, self._highest_m = routes, profile, highest_m
        self._is_low, self.lift_m = False, 0.0

    def kept_off(
        self, told: Setpoint, state: VehicleState | None, is_landing: bool = False
    ) -> tuple[Setpoint, GroundNear | None]:
        """What is sent in place of a setpoint; and what is told, once each time that it is low.

        Args:
            told: the setpoint.
            state: of the vehicle.
            is_landing: it is of the way down to a marker, or up from there.
        """
        was_low, lifted_m = self._is_low, self.lift_m
        self._is_low, self.lift_m = False, 0.0
        if state is None or state.mode is not Mode.OFFBOARD or is_landing:
            return told, None
        by_m = lifted_m if state.below_m is None else self._needed_m(told, state, was_low)
        if by_m <= 0:
            return told, None
        self._is_low, sent = True, self._lifted(told, state, by_m)
        self.lift_m = told.position[2] - sent.position[2]
        if was_low or state.below_m is None:
            return sent, None
        return sent, GroundNear(round(state.below_m, 2), round(-state.position[2], 2))

    def _needed_m(self, told: Setpoint, state: VehicleState, was_low: bool) -> float:
        """By how much a setpoint has to be higher; 0 where it leads clear of what is below."""
        assert state.below_m is not None
        up_m, told_up_m = -state.position[2], -told.position[2]
        top_m = self._routes.top_m(state.position[:2], self._profile.radius_m)
        asked_m = min(self._profile.clearance_m, SHARE * (told_up_m - top_m))
        missing_m = asked_m - (state.below_m + told_up_m - up_m)
        is_low = missing_m > (-CLEAR_AGAIN_M if was_low else 0.0)
        return missing_m + RISE_M if is_low else 0.0

    def _lifted(self, told: Setpoint, state: VehicleState, by_m: float) -> Setpoint:
        """A setpoint that is higher, within the band and the vehicle's carrot."""
        north, east, down = told.position
        most_m = CARROT_SHARE * self._profile.carrot_m
        beside_m = math.dist((north, east), state.position[:2])
        room_m = math.sqrt(max(0.0, most_m**2 - beside_m**2))
        highest_down = max(state.position[2] - room_m, min(-self._highest_m, state.position[2]))
        lifted_down = min(down, max(down - by_m, highest_down))
        v_north, v_east, v_down = told.velocity
        velocity = (v_north, v_east, min(v_down, 0.0))
        return replace(told, position=(north, east, lifted_down), velocity=velocity)
