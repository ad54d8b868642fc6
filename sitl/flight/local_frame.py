"""The autopilot's local frame: north, east and down of its own origin.

The world counts from home; the estimator of a real autopilot lays its origin where it had its first
fix, and may be told another one in flight. Both are projections of one sphere about different
points (geometry.GlobalOrigin), so a position is taken from one to the other by way of latitude and
longitude. Directions are not turned: velocity and heading are those at the vehicle, as in PX4.
"""

from __future__ import annotations

import math

from companion.geometry import GlobalOrigin, Ned
from sitl.flight.physics import FlightState

TOLD_S = 0.5
"""After that a companion has heard of another origin, and its setpoints count from there."""


class LocalFrame:
    """The local frame of one autopilot.

    Args:
        home: where the world's frame lies.
        origin: where the autopilot's lies.

    Attributes:
        origin: now.
    """

    def __init__(self, home: GlobalOrigin, origin: GlobalOrigin) -> None:
        self._home = home
        self.origin = home if origin == home else origin
        self._laid_s = -math.inf

    def lay(self, origin: GlobalOrigin, now_s: float) -> None:
        """The autopilot counts from another origin from now on."""
        self.origin, self._laid_s = origin, now_s

    def is_told(self, now_s: float) -> bool:
        """Whether setpoints count from the present origin."""
        return now_s - self._laid_s >= TOLD_S

    def local(self, position: Ned) -> Ned:
        """A position of the world, as the autopilot tells it."""
        if self.origin == self._home:
            return position
        return self.origin.to_local(*self._home.to_global(position))

    def seen(self, estimate: FlightState) -> FlightState:
        """An estimate of the world's frame, as the autopilot has it."""
        if self.origin is self._home:  # asked in each step
            return estimate
        return estimate._replace(position=self.local(estimate.position))
