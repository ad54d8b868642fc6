"""Delays the autopilot's landing while the vehicle swings towards a wall.

A landing in the autopilot's own mode begins where the vehicle is, with the speed that it has, and
no setpoint keeps it off walls any more (`wall_guard.py`). So if the vehicle is nearer to a wall
than its setpoint, or will be in a second, it is held until a second has passed without that.
"""

from __future__ import annotations

import math

from companion.acting.flight import Flight
from companion.outcomes import Progress
from companion.vehicle.ports.state import Mode

LONGEST_S = 10.0
"""A vehicle that does not come to rest within this time lands as it is."""
STEADY_S = 1.0
"""How long a vehicle that swung has to be off the wall: longer than the middle of a swing."""


class LandingWait:
    """The wait before one landing.

    Args:
        flight: the flight, which stops where it is to land.
    """

    def __init__(self, flight: Flight) -> None:
        self._flight = flight
        self._since_s: float | None = None
        self._approached_s = -math.inf
        self._is_over = False

    def tick(self) -> Progress:
        """Holds the vehicle; DONE once it may land, or is no longer ours to hold."""
        self._is_over = self._is_over or self._may_land()
        return Progress.DONE if self._is_over else Progress.RUNNING

    def _may_land(self) -> bool:
        flight, state = self._flight, self._flight.vehicle.state
        if state is None or state.heartbeat.mode is not Mode.OFFBOARD:
            return True
        flight.guidance.hold()
        now_s = flight.now_s
        if self._since_s is None:
            self._since_s = now_s
        if flight.guidance.approaches_wall:
            self._approached_s = now_s
        return now_s - self._since_s >= LONGEST_S or now_s - self._approached_s >= STEADY_S
