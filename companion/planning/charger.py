"""What charging takes at a dock, in whole units of usable energy.

A dock is landed on, the battery is charged to a level, and the vehicle takes off again. Charging is
the slower the fuller the battery is: the time to a level is convex.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

UNITS_PER_WH = 100


@dataclass(frozen=True, eq=False)
class Charger:
    """A dock that charges.

    Attributes:
        floor: least level on arrival above it: the reserve and the landing.
        landing: what landing takes.
        take_off: what taking off takes.
        overhead_ms: of landing and taking off.
        times_ms: (full + 1,) time from empty to each level; convex.
        called: the level on the ground with which the event of a line that is ready ends a charge;
            None where no line is ready.
        bare: the same without what lines that are ready keep there; None if no line is.
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
        """All of it, to be compared: two docks with the same figures charge alike."""
        times = self.times_ms.tobytes()
        return self.floor, self.landing, self.take_off, self.overhead_ms, times

    @property
    def highest(self) -> int:
        """The highest level after taking off."""
        return len(self.times_ms) - 1 - self.take_off

    @property
    def is_of_use(self) -> bool:
        """Whether it charges more than what has to be there on the ground anyway."""
        return self.floor - self.landing < len(self.times_ms) - 1

    def service_ms(self, arrival: int, departure: int) -> int:
        """Landing, charging and taking off.

        Levels that there cannot be, as in a plan whose flights take more by now, are the nearest.

        Args:
            arrival: level above the dock, on arrival.
            departure: the same after taking off, at most the highest; where it is less than there
                is anyway, nothing is charged.
        """
        full = len(self.times_ms) - 1
        begin = min(max(0, arrival - self.landing), full)
        end = min(max(begin, departure + self.take_off), full)
        return self.overhead_ms + int(self.times_ms[end] - self.times_ms[begin])
