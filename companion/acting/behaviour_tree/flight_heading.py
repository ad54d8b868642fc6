"""The heading of a vehicle while it flies to a place, and on arrival."""

from __future__ import annotations

import math

from companion.acting.flight import Flight
from companion.geometry import NorthEast
from companion.motion.heading import HEADING_TOLERANCE_RAD, error_rad, towards
from companion.motion.trajectory import Sample
from companion.vehicle.ports.state import VehicleState


class FlightHeading:
    """The heading follows the legs, and at the end turns to the place's heading, if it has one.

    If there is a point to look at, the vehicle looks at it all the time, whatever the place says.

    Args:
        flight: its symbols know the heading of each place.
        place: where the flight leads.
        look_at: the point; None to look in the direction of flight.
    """

    def __init__(self, flight: Flight, place: str, look_at: NorthEast | None) -> None:
        self._flight = flight
        self._place = place
        self._look_at = look_at

    def wanted(self, sample: Sample, state: VehicleState, is_at_end: bool) -> float | None:
        """The heading to which the vehicle turns now; None to keep the present one."""
        final_rad = self._final(state)
        is_final = self._look_at is not None or (is_at_end and final_rad is not None)
        return final_rad if is_final else sample.course_rad

    def is_reached(self, state: VehicleState) -> bool:
        """Whether the present heading is good enough to arrive."""
        return self._error_rad(state) <= HEADING_TOLERANCE_RAD

    def error_deg(self, state: VehicleState) -> int:
        """How far the vehicle still has to turn."""
        return round(math.degrees(self._error_rad(state)))

    @property
    def turn_s(self) -> float:
        """How long a turn at the place may take."""
        is_free = self._look_at is None and self._flight.symbols.heading_rad(self._place) is None
        return 0.0 if is_free else math.pi / self._flight.profile.yaw_rate_radps

    def _final(self, state: VehicleState) -> float | None:
        """The heading on arrival; None for any."""
        if self._look_at is not None:
            return towards(state.motion.position, self._look_at)
        return self._flight.symbols.heading_rad(self._place)

    def _error_rad(self, state: VehicleState) -> float:
        final_rad = self._final(state)
        return 0.0 if final_rad is None else error_rad(state.attitude.yaw_rad, final_rad)
