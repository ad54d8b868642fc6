"""Computes the cost of charging at a dock for many levels at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from companion.planning.builtin.costs import UNREACHABLE_MS, Costs
from companion.planning.charger import Charger


def service_costs(charger: Charger, departure: NDArray[np.int64]) -> Costs:
    """The cost to land with the floor's level, charge, and take off, for each of some levels.

    Args:
        charger: the charger of the dock.
        departure: levels above the dock, after taking off; too high a level costs UNREACHABLE_MS.
    """
    begin = charger.floor - charger.landing
    end = np.clip(departure + charger.take_off, begin, len(charger.times_ms) - 1)
    times_ms = charger.overhead_ms + charger.times_ms[end] - charger.times_ms[begin]
    costs: Costs = np.where(departure > charger.highest, UNREACHABLE_MS, times_ms)
    return costs


def costs_at_least(
    chargers: Sequence[Charger], origin: int, goal: int, drains: NDArray[np.int64]
) -> Costs:
    """A lower bound for the cost of a charge, in a lap over docks that do not all charge alike.

    Args:
        chargers: all chargers.
        origin: the charger at which it charges.
        goal: the next charger.
        drains: the energy of flights between the two.
    """
    steps = (
        c.times_ms[c.floor - c.landing + 1] - c.times_ms[c.floor - c.landing] for c in chargers
    )
    gained = chargers[origin].take_off + drains + chargers[goal].landing
    is_open = chargers[goal].floor + drains <= chargers[origin].highest
    least = chargers[origin].overhead_ms + min(steps) * gained
    costs: Costs = np.where(is_open, least, UNREACHABLE_MS)
    return costs
