"""Reports when the gate begins to hold setpoints back."""

from __future__ import annotations

import math
import re

from companion.acting.flight import Flight
from companion.flight_events.sortie import SetpointRefused

CALM_S = 2.0
"""A refusal for the same reason within this time is not reported again."""
_NUMBERS = re.compile(r"[\d.]+")


class GateWatch:
    """Checks the gate once a tick."""

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self._was_refused = False
        self._refused_s, self._told = -math.inf, ""

    def step(self) -> None:
        """Reports the first refusal after setpoints that passed."""
        refusal, now_s = self._flight.vehicle.setpoints.refusal, self._flight.now_s
        if refusal is None:
            self._was_refused = False
            return
        if not self._was_refused:
            reason = _NUMBERS.sub("", refusal.reason)
            if reason != self._told or now_s - self._refused_s > CALM_S:
                self._flight.report(SetpointRefused(refusal.reason))
            self._told = reason
        self._was_refused, self._refused_s = True, now_s
