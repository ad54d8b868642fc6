"""What charging at a dock costs, in whole units of usable energy.

The vehicle lands on the dock, charges to a level, and takes off again. The fuller the battery, the
slower it charges: the time to reach a level is a convex function of the level.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

UNITS_PER_WH = 100


@dataclass(frozen=True, eq=False)
class Charger:
    """A dock at which the vehicle charges.

    Attributes:
        floor: least level on arrival above the dock: the reserve, and the energy to land.
        landing: energy that landing takes.
        take_off: energy that taking off takes.
        overhead_ms: time of landing and taking off.
        times_ms: (full + 1,) time to charge from empty to each level; convex.
        called: the level on the ground at which a charge ends when the event of a ready line comes;
            None if no line is ready.
        bare: the same dock without what ready lines keep there; None if no line is ready.
    """

    floor: int
    landing: int
    take_off: int
    overhead_ms: int
    times_ms: NDArray[np.int64]
    called: int | None = None
    bare: Charger | None = None

    @cached_property
    def figures(self) -> tuple[object, ...]:
        """All figures, for comparison: two docks with equal figures charge alike."""
        times = self.times_ms.tobytes()
        return self.floor, self.landing, self.take_off, self.overhead_ms, times

    @property
    def highest(self) -> int:
        """The highest level after taking off."""
        return len(self.times_ms) - 1 - self.take_off

    @property
    def is_of_use(self) -> bool:
        """Whether it can charge to more than the vehicle must have on the ground anyway."""
        return self.floor - self.landing < len(self.times_ms) - 1

    def service_ms(self, arrival: int, departure: int) -> int:
        """The time to land, charge and take off.

        Impossible levels are replaced by the nearest possible ones. A plan contains such levels if
        its flights take more energy now than when it was made.

        Args:
            arrival: level above the dock on arrival.
            departure: level after taking off; `highest` at most. If it is lower than what the
                vehicle has without charging, nothing is charged.
        """
        full = len(self.times_ms) - 1
        begin = min(max(0, arrival - self.landing), full)
        end = min(max(begin, departure + self.take_off), full)
        return self.overhead_ms + int(self.times_ms[end] - self.times_ms[begin])
