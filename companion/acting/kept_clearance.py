"""Routes keep more from obstacles where the position is less good."""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.flight_events.skills import ClearanceChanged
from companion.motion.position_error import AddedClearance
from companion.vehicle.port import VehicleState


class KeptClearance:
    """Of one flight.

    Args:
        flight: whose routes keep more.
    """

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self._added = AddedClearance(flight.profile.deviation_m)

    def follow(self, state: VehicleState) -> None:
        """Takes how good the position is; once a tick."""
        if not self._added.follow(state.accuracy_m):
            return
        self._flight.routes.add_clearance(self._added.metres)
        clearance_m = round(self._flight.profile.clearance_m + self._added.metres, 3)
        self._flight.report(ClearanceChanged(clearance_m, round(state.accuracy_m, 3)))
