"""The autopilot's local frame: north, east and down from its own origin.

The world counts from home. The estimator of a real autopilot sets its origin at its first fix, and
may be given another one in flight. Both frames are projections of one sphere about different points
(geometry.GlobalOrigin), so a position is converted by way of latitude and longitude. Directions are
not rotated: velocity and heading are those at the vehicle, as in PX4.
"""

from __future__ import annotations

import math

from companion.geometry import GlobalOrigin, Ned
from sitl.flight.physics import FlightState

TOLD_S = 0.5
"""After this time a companion has heard of a new origin, and its setpoints refer to it."""


class LocalFrame:
    """The local frame of one autopilot.

    Args:
        home: the origin of the world's frame.
        origin: the origin of the autopilot's frame.

    Attributes:
        origin: the present one.
    """

    def __init__(self, home: GlobalOrigin, origin: GlobalOrigin) -> None:
        self._home = home
        self.origin = home if origin == home else origin
        self._laid_s = -math.inf

    def lay(self, origin: GlobalOrigin, now_s: float) -> None:
        """Moves the autopilot's origin."""
        self.origin, self._laid_s = origin, now_s

    def is_told(self, now_s: float) -> bool:
        """Whether setpoints refer to the present origin already."""
        return now_s - self._laid_s >= TOLD_S

    def local(self, position: Ned) -> Ned:
        """A position of the world, in the autopilot's frame."""
        if self.origin == self._home:
            return position
        return self.origin.to_local(*self._home.to_global(position))

    def seen(self, estimate: FlightState) -> FlightState:
        """An estimate in the world's frame, in the autopilot's frame."""
        if self.origin is self._home:  # tested in each step
            return estimate
        return estimate._replace(position=self.local(estimate.position))
