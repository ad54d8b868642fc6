"""Where a vehicle looks while it flies to a place, and with what heading it arrives."""

from __future__ import annotations

import math

from companion.acting.flight import Flight
from companion.geometry import NorthEast
from companion.motion.heading import HEADING_TOLERANCE_RAD, error_rad, towards
from companion.motion.trajectory import Sample
from companion.vehicle.port import VehicleState


class FlightHeading:
    """The heading follows the legs, and turns to that of the place, if it has one, at the end.

    Or the vehicle looks at a point from the beginning to the end, whatever the place says.

    Args:
        flight: whose symbols know the heading of each place.
        place: where the flight leads.
        look_at: the point; None to look where it flies.
    """

    def __init__(self, flight: Flight, place: str, look_at: NorthEast | None) -> None:
        self._flight = flight
        self._place = place
        self._look_at = look_at

    def wanted(self, sample: Sample, state: VehicleState, is_at_end: bool) -> float | None:
        """To what heading the vehicle turns now; None to keep the one that it has."""
        final_rad = self._final(state)
        is_final = self._look_at is not None or (is_at_end and final_rad is not None)
        return final_rad if is_final else sample.course_rad

    def is_reached(self, state: VehicleState) -> bool:
        """Whether the vehicle may have arrived with the heading that it has."""
        return self._error_rad(state) <= HEADING_TOLERANCE_RAD

    def error_deg(self, state: VehicleState) -> int:
        """How much it has to turn yet."""
        return round(math.degrees(self._error_rad(state)))

    @property
    def turn_s(self) -> float:
        """How long a turn at the place may take."""
        is_free = self._look_at is None and self._flight.symbols.heading_rad(self._place) is None
        return 0.0 if is_free else math.pi / self._flight.profile.yaw_rate_radps

    def _final(self, state: VehicleState) -> float | None:
        """With what it has arrived; None for any."""
        if self._look_at is not None:
            return towards(state.position, self._look_at)
        return self._flight.symbols.heading_rad(self._place)

    def _error_rad(self, state: VehicleState) -> float:
        final_rad = self._final(state)
        return 0.0 if final_rad is None else error_rad(state.yaw_rad, final_rad)
