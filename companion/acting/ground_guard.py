"""Keeps the vehicle away from the ground, by a range finder that looks down.

The altitude may be wrong: a PX4 v1.15.4 in its own simulator sank to the ground in 4 to 20 s while
its own altitude stayed level. So the vehicle keeps the same distance from what is below it as
routes keep from obstacles beside it, but at most half of the flown height. A setpoint that would
lead nearer is lifted, as far as the altitude band has room, and the flight continues at that
height. The descent to a marker is not changed, nor are the autopilot's own modes (take-off,
landing, hold). While the range finder is silent, a lifted setpoint stays lifted.
"""

from __future__ import annotations

import math
from dataclasses import replace

from companion.flight_events.skills import GroundNear
from companion.motion.layered_routes import LayeredRoutes
from companion.vehicle.ports.setpoints import Setpoint
from companion.vehicle.ports.state import Mode, VehicleState
from companion.vehicle_profile import VehicleProfile

SHARE = 0.5
"""Share of the height above what the map has below: a smaller difference counts as an error."""
RISE_M = 0.5
"""A setpoint is lifted by this much more than is missing, because a sinking vehicle sinks on."""
CLEAR_AGAIN_M = 0.2
"""A setpoint with this much more height than required is no longer lifted."""
CARROT_SHARE = 0.95
"""Share of the distance from the vehicle at which the gate holds a setpoint back."""


class GroundGuard:
    """The guard of one flight.

    Args:
        routes: know what the map has below.
        profile: the vehicle's profile.
        highest_m: the upper end of the altitude band.

    Attributes:
        lift_m: by how much the last setpoint was lifted.
    """

    def __init__(self, routes: LayeredRoutes, profile: VehicleProfile, highest_m: float) -> None:
        self._routes, self._profile, self._highest_m = routes, profile, highest_m
        self._is_low, self.lift_m = False, 0.0

    def kept_off(
        self, told: Setpoint, state: VehicleState | None, is_landing: bool = False
    ) -> tuple[Setpoint, GroundNear | None]:
        """The setpoint to send instead; and an event, once each time that the vehicle is low.

        Args:
            told: the setpoint.
            state: state of the vehicle.
            is_landing: whether it is part of the descent to a marker, or of the climb from there.
        """
        was_low, lifted_m = self._is_low, self.lift_m
        self._is_low, self.lift_m = False, 0.0
        if state is None or state.heartbeat.mode is not Mode.OFFBOARD or is_landing:
            return told, None
        by_m = lifted_m if state.below_m is None else self._needed_m(told, state, was_low)
        if by_m <= 0:
            return told, None
        self._is_low, sent = True, self._lifted(told, state, by_m)
        self.lift_m = told.position[2] - sent.position[2]
        if was_low or state.below_m is None:
            return sent, None
        return sent, GroundNear(round(state.below_m, 2), round(-state.motion.position[2], 2))

    def _needed_m(self, told: Setpoint, state: VehicleState, was_low: bool) -> float:
        """By how much a setpoint has to be higher; 0 if it leads clear of what is below."""
        assert state.below_m is not None
        up_m, told_up_m = -state.motion.position[2], -told.position[2]
        top_m = self._routes.top_m(state.motion.position[:2], self._profile.radius_m)
        asked_m = min(self._profile.clearance_m, SHARE * (told_up_m - top_m))
        missing_m = asked_m - (state.below_m + told_up_m - up_m)
        is_low = missing_m > (-CLEAR_AGAIN_M if was_low else 0.0)
        return missing_m + RISE_M if is_low else 0.0

    def _lifted(self, told: Setpoint, state: VehicleState, by_m: float) -> Setpoint:
        """The setpoint, lifted within the band and within the gate's distance from the vehicle."""
        north, east, down = told.position
        most_m = CARROT_SHARE * self._profile.carrot_m
        beside_m = math.dist((north, east), state.motion.position[:2])
        room_m = math.sqrt(max(0.0, most_m**2 - beside_m**2))
        down_now = state.motion.position[2]
        highest_down = max(down_now - room_m, min(-self._highest_m, down_now))
        lifted_down = min(down, max(down - by_m, highest_down))
        v_north, v_east, v_down = told.velocity
        velocity = (v_north, v_east, min(v_down, 0.0))
        return replace(told, position=(north, east, lifted_down), velocity=velocity)
