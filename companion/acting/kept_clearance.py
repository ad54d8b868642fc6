"""Makes routes keep more clearance if the position is less accurate, or the vehicle off its path.

The heights of places do not change. So it is reported once which places are lower than an
inaccurate height can be relied on.
"""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.flight_events.skills import ClearanceChanged, LowPlacesFlown
from companion.motion.position_error import WORST_HEIGHT_M, AddedClearance
from companion.motion.tracking_error import LOOK_S, TrackingError
from companion.planning.low_places import least_above_m, low_places
from companion.planning.planner import Planner
from companion.vehicle.ports.state import Mode, VehicleState

JUMP_SHARE = 2.0
"""Setpoints further apart than this multiple of what can be flown form no path."""


class KeptClearance:
    """The clearance of one flight.

    Args:
        flight: the flight whose routes keep more.
        planner: the mission's planner.
    """

    def __init__(self, flight: Flight, planner: Planner) -> None:
        self._flight = flight
        self._added = AddedClearance(flight.profile.deviation_m)
        self._tracking = TrackingError(JUMP_SHARE * LOOK_S * flight.limits.speed_mps)
        self._low = low_places(planner)

    def follow(self, state: VehicleState) -> None:
        """Takes the accuracy of the position, and the tracking error; once a tick."""
        off_m = self._off_m(state)
        if not self._added.follow(state.motion.accuracy_m, off_m):
            return
        self._flight.routes.add_clearance(self._added.metres)
        kept_m = self._flight.profile.clearance_m + self._added.metres
        changed = ClearanceChanged(
            clearance_m=round(kept_m, 3),
            accuracy_m=round(state.motion.accuracy_m, 3),
            off_m=round(off_m, 3),
        )
        self._flight.report(changed)
        if self._low and self._added.metres:
            least_m = least_above_m(self._flight.profile)
            names = tuple(place.name for place in self._low)
            self._flight.report(LowPlacesFlown(names, least_m, WORST_HEIGHT_M))
            self._low = ()

    def _off_m(self, state: VehicleState) -> float:
        """The largest distance of the vehicle from the path of its setpoints, if there are any."""
        told, now_s = self._flight.guidance.setpoint, self._flight.now_s
        is_flown = state.heartbeat.mode is Mode.OFFBOARD and not state.is_landed
        if told is None or not is_flown or state.motion.silence_s(now_s) > LOOK_S:
            self._tracking.pause(now_s)
        else:
            self._tracking.follow(now_s, told.position[:2], state.motion.position[:2])
        return self._tracking.off_m
