"""Routes keep more from obstacles where the position is less good; heights of places do not.

So it is told once which places are flown to lower than such a vehicle's height is certain.
"""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.flight_events.skills import ClearanceChanged, LowPlacesFlown
from companion.motion.position_error import WORST_HEIGHT_M, AddedClearance
from companion.planning.low_places import least_above_m, low_places
from companion.planning.planner import Planner
from companion.vehicle.port import VehicleState


class KeptClearance:
    """Of one flight.

    Args:
        flight: whose routes keep more.
        planner: of its mission.
    """

    def __init__(self, flight: Flight, planner: Planner) -> None:
        self._flight = flight
        self._added = AddedClearance(flight.profile.deviation_m)
        self._low = low_places(planner)

    def follow(self, state: VehicleState) -> None:
        """Takes how good the position is; once a tick."""
        if not self._added.follow(state.accuracy_m):
            return
        self._flight.routes.add_clearance(self._added.metres)
        clearance_m = round(self._flight.profile.clearance_m + self._added.metres, 3)
        self._flight.report(ClearanceChanged(clearance_m, round(state.accuracy_m, 3)))
        if self._low and self._added.metres:
            least_m = least_above_m(self._flight.profile)
            names = tuple(place.name for place in self._low)
            self._flight.report(LowPlacesFlown(names, least_m, WORST_HEIGHT_M))
            self._low = ()
