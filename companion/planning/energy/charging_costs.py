"""What charging at a dock costs for many levels at once."""

from __future__ import annotations

from collections.abc import Sequence

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


def costs_at_least(
    chargers: Sequence[Charger], origin: int, goal: int, drains: NDArray[np.int64]
) -> Costs:
    """What a charge cannot take less than, in a lap over docks that do not charge alike.

    Args:
        chargers: all that there are.
        origin: the one at which it charges.
        goal: the next one.
        drains: of flights between them.
    """
    steps = (
        c.times_ms[c.floor - c.landing + 1] - c.times_ms[c.floor - c.landing] for c in chargers
    )
    gained = chargers[origin].take_off + drains + chargers[goal].landing
    is_open = chargers[goal].floor + drains <= chargers[origin].highest
    least = chargers[origin].overhead_ms + min(steps) * gained
    costs: Costs = np.where(is_open, least, UNREACHABLE_MS)
    return costs
