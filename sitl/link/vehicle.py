"""Of whom does the telemetry speak?"""

from __future__ import annotations

from dataclasses import dataclass

from companion.geometry import GlobalOrigin
from sitl.autopilot.autopilot import Autopilot
from sitl.flight.physics import FlightState


@dataclass(slots=True)
class Vehicle:
    """What the messages are made of; `state` is replaced every step."""

    autopilot: Autopilot
    state: FlightState
    origin: GlobalOrigin

    @property
    def boot_ms(self) -> int:
        """Time since start, ms."""
        return round(self.state.time_s * 1e3)

    @property
    def boot_us(self) -> int:
        """Time since start, us."""
        return round(self.state.time_s * 1e6)
