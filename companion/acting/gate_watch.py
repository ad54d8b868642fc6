"""Tells when the gate begins to hold setpoints back."""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.flight_events.sortie import SetpointRefused


class GateWatch:
    """Looks at the gate once a tick."""

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self._was_refused = False

    def step(self) -> None:
        """Reports the first refusal after a setpoint that was let out."""
        refusal = self._flight.vehicle.refusal
        if refusal is not None and not self._was_refused:
            self._flight.report(SetpointRefused(refusal.reason))
        self._was_refused = refusal is not None
