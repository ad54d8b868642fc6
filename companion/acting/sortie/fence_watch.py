"""Reports when somebody changes the autopilot's fence after it was checked.

The flight goes on within the fence that was checked: the new one can be read only on the ground,
and the autopilot itself stops a vehicle that leaves it. The operator has to know why.
"""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.acting.sortie.phases import ON_THE_GROUND
from companion.flight_events.fence import FenceChange, FenceChanged
from companion.flight_events.sortie import Phase


class FenceWatch:
    """The watch of one sortie.

    Args:
        flight: the flight.
    """

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self._number: int | None = None

    def step(self, phase: Phase) -> None:
        """Compares the fence with that of the tick before, once a tick."""
        number, before = self._flight.vehicle.fence.number, self._number
        if number is None or number == before:
            return
        self._number = number
        if before is not None and phase not in ON_THE_GROUND:
            change = FenceChange.REPLACED if number else FenceChange.REMOVED
            self._flight.report(FenceChanged(change))
