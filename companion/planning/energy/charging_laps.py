"""Laps that can be flown for ever on one battery: closed chains of sorties that meet every mark.

Each part between two charges is a sortie (`sorties.py`). It begins with the level that brings the
vehicle to the next dock at that dock's floor. If all docks charge alike, more is never worthwhile:
a battery charges the slower the fuller it is, so the extra energy is charged more quickly at the
next dock. Then every lap begins and ends at the floor of its dock and can be flown for ever, and
the shortest chain is the shortest lap of all. If docks do not charge alike, it is a good lap, and
the bound assumes that all charging is as quick as anywhere.

Source: Held and Karp 1962, for the sorties; a min-plus product over sets of marks for the chains.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from companion.planning.builtin.costs import UNREACHABLE_MS, Costs
from companion.planning.charger import Charger
from companion.planning.effort import ADDITION_US
from companion.planning.energy.charging_costs import costs_at_least, service_costs
from companion.planning.energy.sorties import PathTables, Sorties, subsets
from companion.slices import spent

Numbers = NDArray[np.int64]
_LAYER_US, _PART_ADDITIONS = 100.0, 2


@dataclass(frozen=True, slots=True)
class ChargedSortie:
    """A charge, and the flight to the next charge.

    Attributes:
        dock: the stop where the vehicle charges.
        departure: the level after taking off.
        targets: the stops of the flight, in their order.
        cost_ms: time of charge and flight.
        is_thrifty: whether its paths take the least energy, instead of the least time.
    """

    dock: int
    departure: int
    targets: tuple[int, ...]
    cost_ms: int
    is_thrifty: bool = False


@dataclass(frozen=True, slots=True)
class ChargingLap:
    """A lap: consecutive sorties, the last of which leads to where the first begins.

    Attributes:
        bound_ms: a lower bound for all laps; 0 if nothing is known.
    """

    sorties: tuple[ChargedSortie, ...]
    cost_ms: int
    bound_ms: int


class ChargingLaps:
    """The laps over some stops.

    Args:
        paths: the paths between all stops.
        chargers: by stop, its charger.
    """

    def __init__(self, paths: PathTables, chargers: dict[int, Charger]) -> None:
        self._docks = list(chargers)
        self._chargers = list(chargers.values())
        self._sorties = Sorties(paths, self._docks)
        size = len(self._docks)
        shape = size, size, paths.sets
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
        """Computes the cost of all sorties between two docks."""
        found, floor = self._sorties.between(i, j), self._chargers[j].floor
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

    def best(self, with_bound: bool = True) -> ChargingLap | None:
        """The shortest lap; None if there is none.

        Args:
            with_bound: whether to compute its bound.
        """
        costs = _Chains(self._costs)
        anchor = int(costs.laps_ms.argmin())
        if costs.laps_ms[anchor] >= UNREACHABLE_MS:
            return None
        sorties = tuple(self._sortie(*step) for step in costs.steps(anchor))
        bounds = costs if not with_bound or self._is_exact else _Chains(self._bounds)
        bound_ms = int(bounds.laps_ms.min()) if with_bound or self._is_exact else 0
        return ChargingLap(sorties, int(costs.laps_ms[anchor]), bound_ms)

    @property
    def _is_exact(self) -> bool:
        return np.array_equal(self._bounds, self._costs)

    def _sortie(self, i: int, j: int, marks: int) -> ChargedSortie:
        is_thrifty = bool(self._is_thrifty[i, j, marks])
        return ChargedSortie(
            self._docks[i],
            int(self._departures[i, j, marks]),
            tuple(self._sorties.path(i, j, marks, is_thrifty)),
            int(self._costs[i, j, marks]),
            is_thrifty,
        )


class _Chains:
    """The cheapest chains of sorties whose first sortie meets the first mark.

    Each lap that meets all marks contains such a sortie, with which it can begin. A chain may end
    with flights to another dock that meet no mark.

    Attributes:
        laps_ms: (docks,) closed chains of at least one sortie that meet every mark.
    """

    def __init__(self, costs: Costs) -> None:
        self._costs = costs
        size, _, sets = costs.shape
        self._between = _closure(costs[:, :, 0])
        if sets == 1:
            self.laps_ms = (costs[:, :, 0] + self._between.T).min(axis=1)
            return
        first = costs[:, :, 1::2]  # with the first mark; the others form a set
        self._reached = _product(first, self._between)  # from, to, others
        for met, parts in _parts(sets // 2):
            spent(_LAYER_US + ADDITION_US * _PART_ADDITIONS * parts.size * size**3)
            before = self._reached[:, :, met[:, None] ^ parts]  # (from, via, met, part)
            onward = costs[:, :, 2 * parts]  # (via, to, met, part)
            least = np.min(
                [(before[:, via, None] + onward[via]).min(axis=-1) for via in range(size)], axis=0
            )
            least = np.minimum(least, first[:, :, met])
            self._reached[:, :, met] = _product(least, self._between)
        self.laps_ms = self._reached[np.arange(size), np.arange(size), -1]

    def steps(self, start: int) -> list[tuple[int, int, int]]:
        """The sorties of the closed chain: from, to, and the marks that each has to meet."""
        if self._costs.shape[2] == 1:
            there = int((self._costs[start, :, 0] + self._between[:, start]).argmin())
            return [(start, there, 0), *self._transfer(there, start)]
        steps: list[tuple[int, int, int]] = []
        here, met, is_first = start, self._reached.shape[2] - 1, False
        while not is_first:
            via, last, part, is_first = self._last_sortie(start, here, met)
            steps += reversed(self._transfer(last, here))
            steps.append((via, last, part))
            here, met = via, met ^ part // 2
        return steps[::-1]

    def _last_sortie(self, start: int, end: int, met: int) -> tuple[int, int, int, bool]:
        """The last sortie of a chain that meets a mark: from, to, marks, whether the only one.

        Args:
            start: where the chain begins.
            end: where it ends.
            met: the marks that it meets, besides the first mark.
        """
        whole = self._costs[start, :, 2 * met + 1] + self._between[:, end]
        last = int(whole.argmin())
        if whole[last] == self._reached[start, end, met]:
            return start, last, 2 * met + 1, True
        parts = np.array([part for part in subsets(met) if part])
        before = self._reached[start][:, None, met ^ parts] + self._costs[:, :, 2 * parts]
        chains = before + self._between[:, end, None]  # (via, last, part)
        via, last, which = map(int, np.unravel_index(int(chains.argmin()), chains.shape))
        return via, last, 2 * int(parts[which]), False

    def _transfer(self, start: int, end: int) -> list[tuple[int, int, int]]:
        """The sorties without marks from one dock to another."""
        steps, here = [], start
        while here != end:
            direct = self._costs[here, :, 0] + self._between[:, end]
            direct[here] = UNREACHABLE_MS
            there = int(direct.argmin())
            steps.append((here, there, 0))
            here = there
        return steps


@cache
def _parts(sets: int) -> list[tuple[Numbers, Numbers]]:
    """Sets of marks, grouped by size, and the nonempty parts of each."""
    parts: list[Numbers] = [np.array([], np.int64)]
    for met in range(1, sets):
        low = met & -met
        rest = parts[met ^ low]
        parts.append(np.concatenate((rest, rest | low, [low])))
    sizes = np.bitwise_count(np.arange(sets))
    layers = [np.flatnonzero(sizes == size) for size in range(1, int(sizes.max()) + 1)]
    return [(layer, np.array([parts[met] for met in layer.tolist()])) for layer in layers]


def _closure(costs: Costs) -> Costs:
    """The cheapest chains of any length, including none."""
    found = costs.copy()
    np.fill_diagonal(found, 0)
    for via in range(len(found)):
        found = np.minimum(found, found[:, via, None] + found[via])
    return np.minimum(found, UNREACHABLE_MS)


def _product(chains: Costs, between: Costs) -> Costs:
    """(from, to, sets) chains from (from, via, sets), each followed by the cheapest flights."""
    found: Costs = (chains[:, :, None] + between[None, :, :, None]).min(axis=1)
    return np.minimum(found, UNREACHABLE_MS)


def in_order(sorties: Sequence[ChargedSortie]) -> list[int]:
    """All stops of a lap in their order, including docks."""
    return [stop for sortie in sorties for stop in (sortie.dock, *sortie.targets)]
