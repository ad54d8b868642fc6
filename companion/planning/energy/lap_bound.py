"""A lower bound for the cost of laps on a battery, if laps are not proved to be the shortest.

A lap with a given number of charges is a tour over its marks and that many docks. A 1-tree bounds
the time and the energy of such a tour from below. That energy has to be charged. A battery charges
the slower the fuller it is, so charging takes least time if all charges are equal. One more charge
never makes a tour shorter, and adds a landing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from companion.planning.builtin.costs import UNREACHABLE_MS, Marks
from companion.planning.builtin.one_tree import lower_bound_ms
from companion.planning.charger import Charger
from companion.planning.energy.charging_laps import ChargedSortie
from companion.planning.energy.sorties import PathTables

_LOOKS = 3
"""How often the necessary number of charges is recomputed: with more charges a tour takes more."""
_MORE_CHARGES = 2
"""How many charges beyond the necessary number may pay off, by charging less each time."""
_ROUNDED_MS = 1
"""How much the time of a charge may be rounded up."""


def lap_bound_ms(
    paths: PathTables, chargers: Mapping[int, Charger], marks: int, lap: Sequence[ChargedSortie]
) -> int:
    """A lower bound for the cost of all laps.

    Args:
        paths: the paths between all stops.
        chargers: by stop.
        marks: number of marks.
        lap: a known lap.
    """
    return _LapBound(paths, chargers, marks, lap).least_ms()


class _LapBound:
    """Bounds for each number of charges."""

    def __init__(
        self,
        paths: PathTables,
        chargers: Mapping[int, Charger],
        marks: int,
        lap: Sequence[ChargedSortie],
    ) -> None:
        stops = [s for s in range(len(paths.marks)) if s in chargers or s not in paths.docks]
        kept = np.ix_(stops, stops)
        self._times_ms, self._drains = (
            paths.quickest.times_ms[kept],
            paths.least_energy.drains[kept],
        )
        own = paths.marks[stops]
        self._marks: Marks = np.array([own >> mark & 1 for mark in range(marks)], np.bool_).T
        self._is_dock = np.array([stop in chargers for stop in stops])
        all_ = list(chargers.values())
        self._room = max(c.highest for c in all_) - min(c.floor for c in all_)
        self._landed = min(c.landing + c.take_off for c in all_)
        self._overhead_ms = min(c.overhead_ms for c in all_)
        self._begun = min(c.floor - c.landing for c in all_)
        self._charging_ms = np.min([c.times_ms - c.times_ms[self._begun] for c in all_], axis=0)
        self._rise_ms = min(_rise_ms(c.times_ms, self._begun) for c in all_)
        self._lap_ms = sum(sortie.cost_ms for sortie in lap)
        ends = [*lap[1:], lap[0]]
        self._used = sum(
            a.departure - chargers[b.dock].floor for a, b in zip(lap, ends, strict=True)
        )

    def least_ms(self) -> int:
        """The lower bound for laps with any number of charges."""
        charges = 1
        for _ in range(_LOOKS):
            charges = max(charges, math.ceil(self._drained(charges) / self._room))
        found = [self._with(charges + more) for more in range(_MORE_CHARGES)]
        return min(self._lap_ms, *found, self._linear_ms(charges + _MORE_CHARGES))

    def _with(self, charges: int) -> int:
        """The least cost of a lap with so many charges."""
        each = self._drained(charges) / charges + self._landed
        level = min(self._begun + math.floor(each), len(self._charging_ms) - 1)
        charge_ms = int(self._charging_ms[level]) - _ROUNDED_MS + self._overhead_ms
        flown_ms = self._tour(self._times_ms, charges, self._lap_ms - charges * charge_ms)
        return max(self._linear_ms(charges), flown_ms + charges * charge_ms)

    def _linear_ms(self, charges: int) -> int:
        """The same, if all energy were charged at the greatest rate anywhere."""
        costs = np.floor(self._times_ms + self._rise_ms * self._drains).astype(np.int64)
        landed_ms = self._overhead_ms + math.floor(self._rise_ms * self._landed) - _ROUNDED_MS
        landings_ms = charges * landed_ms
        return self._tour(costs, charges, self._lap_ms - landings_ms) + landings_ms

    def _drained(self, charges: int) -> int:
        return self._tour(self._drains, charges, self._used)

    def _tour(self, costs: NDArray[np.int64], docks: int, known: int) -> int:
        """A lower bound for a tour over all marks and some docks; close to a real one."""
        marks = np.hstack([self._marks, np.repeat(self._is_dock[:, None], docks, axis=1)])
        between = np.where(self._times_ms < UNREACHABLE_MS, costs, UNREACHABLE_MS)
        return lower_bound_ms(between, marks, max(1, known))


def _rise_ms(times_ms: NDArray[np.int64], level: int) -> float:
    """The least time to charge one unit from a level on, since times are rounded up."""
    if not level:
        return float(times_ms[1] - times_ms[0] - _ROUNDED_MS)
    before = np.arange(level)
    return float(((times_ms[level] - _ROUNDED_MS - times_ms[before]) / (level - before)).max())
