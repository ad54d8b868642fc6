"""What charging at a dock costs for many levels at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from companion.planning.builtin.costs import UNREACHABLE_MS, Costs
from companion.planning.charger import Charger


def service_costs(charger: Charger, departure: NDArray[np.int64]) -> Costs:
    """Landing at the charger's floor, charging and taking off, for each of some levels after it.

    Args:
        charger: at the dock.
        departure: levels above the dock, after taking off; one that is too high costs
            UNREACHABLE_MS.
    """
    begin = charger.floor - charger.landing
    end = np.clip(departure + charger.take_off, begin, len(charger.times_ms) - 1)
    times_ms = charger.overhead_ms + charger.times_ms[end] - charger.times_ms[begin]
    costs: Costs = np.where(departure > charger.highest, UNREACHABLE_MS, times_ms)
    return costs
