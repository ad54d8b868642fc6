"""Holds a vehicle that waits for a plan; if the map may change, the vehicle turns to and fro.

The beams of a range finder that does not turn miss most of a door 5 m away, and what they miss
stays on the map as it was last seen.
"""

from __future__ import annotations

import math
from collections.abc import Collection

from companion.acting.flight import Flight
from companion.acting.replanning.patience import THE_MAP
from companion.motion.heading import sweep_rad

APART_S = 2.0
"""Holds further apart belong to separate waits; the second starts a new turn to and fro."""


class WaitingHold:
    """The holds of one flight.

    Args:
        flight: the flight.
    """

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self._heading_rad = 0.0
        self._facing_s = 0.0
        self._held_s = -math.inf

    def tick(self, hopes: Collection[str]) -> None:
        """Holds for a tick.

        Args:
            hopes: the changes that may make a plan possible.
        """
        flight = self._flight
        if THE_MAP not in hopes:
            flight.guidance.hold()
            return
        if flight.now_s - self._held_s > APART_S:
            self._heading_rad, self._facing_s = flight.guidance.heading_rad, flight.now_s
        self._held_s = flight.now_s
        flight.guidance.hold(self._heading_rad + sweep_rad(flight.now_s - self._facing_s))
