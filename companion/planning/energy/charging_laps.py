"""Laps that last for ever on one battery: closed chains of sorties that meet every mark.

Each stretch between two charges is a sortie (`sorties.py`), and begins with as much as brings the
vehicle to the next dock at that one's floor. More is never worth it where all docks charge alike:
charging is the slower the fuller the battery, so what would be carried on is charged more quickly
at the next dock. Then every lap begins and ends at the floor of its dock, and can be flown for
ever; and the shortest chain is the shortest lap of all. Where they do not charge alike it is a good
one, and the bound counts all charge as quickly as it comes anywhere.

Source: Held and Karp 1962, for the sorties; a min-plus product over sets of marks for the chains.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from companion.planning.builtin.costs import UNREACHABLE_MS, Costs
from companion.planning.charger import Charger
from companion.planning.effort import ADDITION_US
from companion.planning.energy.charging_costs import costs_at_least, service_costs
from companion.planning.energy.sorties import Sorties, WayTables
from companion.slices import spent

_SET_US, _PART_US = 20.0, 3.0


@dataclass(frozen=True, slots=True)
class ChargedSortie:
    """A charge, and the flight to the next one.

    Attributes:
        dock: where the vehicle charges, a stop.
        departure: the level after taking off.
        targets: stops on the way, in their order.
        cost_ms: of charge and flight.
        is_thrifty: its ways are the thriftiest, not the quickest.
    """

    dock: int
    departure: int
    targets: tuple[int, ...]
    cost_ms: int
    is_thrifty: bool = False


@dataclass(frozen=True, slots=True)
class ChargingLap:
    """A lap: sorties one after the other, the last one to where the first begins.

    Attributes:
        bound_ms: no lap is shorter.
    """

    sorties: tuple[ChargedSortie, ...]
    cost_ms: int
    bound_ms: int


class ChargingLaps:
    """The laps over some stops.

    Args:
        ways: between all stops.
        chargers: by stop, what charging takes there.
    """

    def __init__(self, ways: WayTables, chargers: dict[int, Charger]) -> None:
        self._docks = list(chargers)
        self._chargers = list(chargers.values())
        self._sorties = [Sorties(ways, dock) for dock in self._docks]
        size = len(self._docks)
        shape = size, size, ways.sets
        self._costs = np.full(shape, UNREACHABLE_MS)
        self._bounds = np.full(shape, UNREACHABLE_MS)
        self._departures = np.zeros(shape, np.int64)
        self._is_thrifty = np.zeros(shape, np.bool_)
        first = self._chargers[0].times_ms
        self._is_alike = all(np.array_equal(each.times_ms, first) for each in self._chargers)
        for i, charger in enumerate(self._chargers):
            for j in range(size):
                self._price(i, j, charger)

    def _price(self, i: int, j: int, charger: Charger) -> None:
        """The cost of all sorties between two docks."""
        found, floor = self._sorties[i].to(self._docks[j]), self._chargers[j].floor
        costs = []
        for times_ms, drains in (
            (found.quickest_ms, found.quickest_drain),
            (found.thriftiest_ms, found.thriftiest_drain),
        ):
            service_ms = service_costs(charger, floor + drains)
            costs.append(np.minimum(times_ms + service_ms, UNREACHABLE_MS))
        least = costs_at_least(self._chargers, i, j, found.thriftiest_drain)
        if self._is_alike:
            least = service_costs(charger, floor + found.thriftiest_drain)
        self._is_thrifty[i, j] = is_thrifty = costs[1] < costs[0]
        self._costs[i, j] = np.where(is_thrifty, costs[1], costs[0])
        self._bounds[i, j] = np.minimum(found.quickest_ms + least, UNREACHABLE_MS)
        drains = np.where(is_thrifty, found.thriftiest_drain, found.quickest_drain)
        self._departures[i, j] = floor + drains

    def best(self) -> ChargingLap | None:
        """The shortest lap; None if there is none."""
        costs = _Chains(self._costs)
        everything = self._costs.shape[2] - 1
        laps_ms = costs.laps_ms[:, everything]
        anchor = int(laps_ms.argmin())
        if laps_ms[anchor] >= UNREACHABLE_MS:
            return None
        is_exact = np.array_equal(self._bounds, self._costs)
        bounds = costs if is_exact else _Chains(self._bounds)
        bound_ms = int(bounds.laps_ms[:, everything].min())
        steps = costs.steps(anchor, everything)
        sorties = tuple(self._sortie(*step) for step in steps)
        return ChargingLap(sorties, int(laps_ms[anchor]), bound_ms)

    def _sortie(self, i: int, j: int, marks: int) -> ChargedSortie:
        is_thrifty = bool(self._is_thrifty[i, j, marks])
        return ChargedSortie(
            self._docks[i],
            int(self._departures[i, j, marks]),
            tuple(self._sorties[i].path(self._docks[j], marks, is_thrifty)),
            int(self._costs[i, j, marks]),
            is_thrifty,
        )


class _Chains:
    """The cheapest chains of sorties from each dock, for each set of marks.

    Attributes:
        laps_ms: (docks, sets) closed chains of at least one sortie.
    """

    def __init__(self, costs: Costs) -> None:
        self._costs = costs
        size, _, sets = costs.shape
        self._between = _closure(costs[:, :, 0])
        reached = np.full((size, size, sets), UNREACHABLE_MS)  # from, to, met
        reached[:, :, 0] = self._between
        subsets = [np.array([0])]
        for met in range(1, sets):
            low = met & -met
            rest = subsets[met ^ low]
            subsets.append(np.concatenate((rest, rest | low)))
        for met in range(1, sets):
            parts = subsets[met][subsets[met] > 0]
            spent(_SET_US + ADDITION_US * len(parts) * size**3)
            before = reached[:, :, met ^ parts]  # (from, via, parts)
            onward = costs[:, :, parts]  # (via, to, parts)
            least = (before[:, :, None] + onward[None]).min(axis=(1, 3))
            reached[:, :, met] = _product(np.minimum(least, UNREACHABLE_MS), self._between)
        self._reached, self._subsets = reached, subsets
        self.laps_ms = np.array([reached[i, i] for i in range(size)])
        self.laps_ms[:, 0] = (costs[:, :, 0] + self._between.T).min(axis=1)

    def steps(self, start: int, met: int) -> list[tuple[int, int, int]]:
        """The sorties of a closed chain: from, to, and the marks that each has to meet."""
        if not met:
            there = int((self._costs[start, :, 0] + self._between[:, start]).argmin())
            return [(start, there, 0), *self._transfer(there, start)]
        steps: list[tuple[int, int, int]] = []
        here = start
        while met:
            last = int(
                (self._reached_without_transfer(start, met) + self._between[:, here]).argmin()
            )
            steps += reversed(self._transfer(last, here))
            cost = self._reached_without_transfer(start, met)[last]
            via, part = self._last_sortie(start, last, met, int(cost))
            steps.append((via, last, part))
            here, met = via, met ^ part
        steps += reversed(self._transfer(start, here))
        return steps[::-1]

    def _reached_without_transfer(self, start: int, met: int) -> Costs:
        parts = self._subsets[met][self._subsets[met] > 0]
        before, onward = self._reached[start][:, met ^ parts], self._costs[:, :, parts]
        least: Costs = (before[:, None] + onward).min(axis=(0, 2))
        return least

    def _last_sortie(self, start: int, end: int, met: int, cost_ms: int) -> tuple[int, int]:
        for part in self._subsets[met][self._subsets[met] > 0].tolist():
            spent(_PART_US)
            costs = self._reached[start][:, met ^ part] + self._costs[:, end, part]
            if (via := int(costs.argmin())) is not None and costs[via] == cost_ms:
                return via, part
        raise AssertionError("a chain without a beginning")

    def _transfer(self, start: int, end: int) -> list[tuple[int, int, int]]:
        """The sorties without marks from a dock to another."""
        steps, here = [], start
        while here != end:
            direct = self._costs[here, :, 0] + self._between[:, end]
            direct[here] = UNREACHABLE_MS
            there = int(direct.argmin())
            steps.append((here, there, 0))
            here = there
        return steps


def _closure(costs: Costs) -> Costs:
    """The cheapest chains of any length, none included."""
    found = costs.copy()
    np.fill_diagonal(found, 0)
    for via in range(len(found)):
        found = np.minimum(found, found[:, via, None] + found[via])
    return np.minimum(found, UNREACHABLE_MS)


def _product(left: Costs, right: Costs) -> Costs:
    found: Costs = np.minimum((left[:, :, None] + right[None]).min(axis=1), UNREACHABLE_MS)
    return found


def in_order(sorties: Sequence[ChargedSortie]) -> list[int]:
    """All stops of a lap in their order, docks included."""
    return [stop for sortie in sorties for stop in (sortie.dock, *sortie.targets)]
