"""The battery of a vehicle in numbers: its energy, and the power that flying takes.

Flights are calculated in energy and not in charge: the current rises as the voltage falls, but the
power of a hover is constant. The defaults are those of the bundled simulator's vehicle.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

Points = tuple[tuple[float, float], ...]
"""Points of a function in ascending order; linear between them."""


def interpolated(points: Sequence[tuple[float, float]], x: float) -> float:
    """A function that is linear between points, and is extrapolated beyond the last ones.

    >>> interpolated([(0.0, 1.0), (2.0, 5.0)], 1.0), interpolated([(0.0, 1.0), (2.0, 5.0)], 3.0)
    (3.0, 7.0)
    """
    if len(points) == 1:
        return points[0][1]
    place = bisect_right([at for at, _ in points], x, 1, len(points) - 1)
    (a, f), (b, g) = points[place - 1], points[place]
    return f + (g - f) * (x - a) / (b - a)


@dataclass(frozen=True, slots=True)
class BatteryProfile:
    """A battery, and the power of the vehicle that it drives.

    Attributes:
        capacity_wh: usable energy of a full, new one at the power of a hover.
        curve: charge, 0 to 1, and the share of the energy that remains at that charge.
        level_w: airspeed in m/s, from 0, and the power of level flight.
        climb_w: climb rate in m/s, negative for a descent, and the power at airspeed 0.

    >>> battery = BatteryProfile()
    >>> battery.power_w(0.0), round(battery.power_w(5.0, 1.0), 1)
    (189.4, 202.5)
    >>> round(battery.energy_wh(0.5), 1), round(battery.charge(battery.energy_wh(0.5)), 6)
    (36.3, 0.5)
    """

    capacity_wh: float = 75.5
    curve: Points = (
        (0.0, 0.0),
        (0.1, 0.091),
        (0.2, 0.187),
        (0.4, 0.382),
        (0.6, 0.58),
        (0.8, 0.786),
        (0.9, 0.892),
        (1.0, 1.0),
    )
    level_w: Points = (
        (0.0, 189.4),
        (2.0, 189.7),
        (5.0, 192.0),
        (8.0, 198.0),
        (10.0, 204.8),
        (12.0, 214.3),
    )
    climb_w: Points = ((-1.0, 179.4), (0.0, 189.4), (1.0, 199.9), (3.0, 225.0))

    def power_w(self, airspeed_mps: float, climb_mps: float = 0.0) -> float:
        """The power at an airspeed and a climb rate."""
        rising_w = interpolated(self.climb_w, climb_mps) - interpolated(self.climb_w, 0.0)
        return interpolated(self.level_w, airspeed_mps) + rising_w

    def energy_wh(self, charge: float) -> float:
        """The remaining energy at a charge, 0 to 1."""
        return self.capacity_wh * interpolated(self.curve, charge)

    def charge(self, energy_wh: float) -> float:
        """The charge at a remaining energy."""
        inverse = [(share, charge) for charge, share in self.curve]
        return interpolated(inverse, energy_wh / self.capacity_wh)
