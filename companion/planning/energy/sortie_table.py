"""The least cost of every sortie, over up to twenty marks, or more if a battery is small.

For each dock, Held and Karp's dynamic programme over sets is run, for all sets of one size at once:
once with the quickest paths and once with those of least energy. A set is dropped as soon as the
battery does not last for it, together with all sets that contain it. The cost of a sortie is
computed from the least time and the least energy for its set. These may belong to two different
orders, so it is a lower bound.

A sortie over a part of a set costs no more than one over the whole set, because paths are shortest:
leaving out a stop makes nothing longer. So it is enough to search for laps that meet no mark twice.

Source: Held and Karp, A dynamic programming approach to sequencing problems, 1962.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from companion.planning.builtin.costs import UNREACHABLE_MS
from companion.planning.charger import Charger
from companion.planning.effort import ADDITION_US
from companion.planning.energy.charging_costs import costs_at_least, service_costs
from companion.planning.energy.sorties import PathTables
from companion.slices import spent

MOST_MARKS = 24
MOST_SETS = 1_100_000
"""The most sets of a dock, all sets of twenty marks. Beyond it no table is made."""
_FAR = 1 << 29
"""More than any time or drain; the sum of two of them fits into 32 bits."""
_BATCH = 1 << 13
"""Number of sets processed at once, so that a batch fits into the processor's cache."""

Whole = NDArray[np.int32]
Numbers = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class SortieTable:
    """All sorties that a battery lasts for; each array is (sorties,).

    Attributes:
        origins: indices of docks.
        ends: indices of docks.
        sets: the marks that are met.
        costs_ms: lower bounds for the time of charge and flight.
    """

    origins: NDArray[np.int8]
    ends: NDArray[np.int8]
    sets: Whole
    costs_ms: Numbers

    def of(self, chosen: NDArray[np.bool_] | NDArray[np.intp] | slice) -> SortieTable:
        """A selection of them."""
        return SortieTable(
            self.origins[chosen], self.ends[chosen], self.sets[chosen], self.costs_ms[chosen]
        )

    def with_(self, others: SortieTable) -> SortieTable:
        """These and others together."""
        return SortieTable(
            np.concatenate((self.origins, others.origins)),
            np.concatenate((self.ends, others.ends)),
            np.concatenate((self.sets, others.sets)),
            np.concatenate((self.costs_ms, others.costs_ms)),
        )


def sortie_table(
    paths: PathTables, chargers: Mapping[int, Charger], marks: int
) -> SortieTable | None:
    """All sorties between some docks; None if there are too many, or a stop meets several marks.

    Args:
        paths: the paths between all stops.
        chargers: by stop.
        marks: number of marks.
    """
    own = paths.marks[[s for s in range(len(paths.marks)) if s not in paths.docks]]
    is_simple = all(mark.bit_count() == 1 for mark in own.tolist())
    if marks > MOST_MARKS or not is_simple or paths.marks[list(paths.docks)].any():
        return None
    longest_ms = paths.quickest.times_ms[paths.quickest.times_ms < UNREACHABLE_MS].max(initial=0)
    if longest_ms * (marks + 1) >= _FAR:
        return None
    parts = []
    for origin in chargers:
        if (found := _from(paths, chargers, marks, origin)) is None:
            return None
        parts += found
    origins, ends, sets, costs_ms = (np.concatenate(each) for each in zip(*parts, strict=True))
    return SortieTable(origins, ends, sets, costs_ms)


_Part = tuple[NDArray[np.int8], NDArray[np.int8], Whole, Numbers]


def _from(
    paths: PathTables, chargers: Mapping[int, Charger], marks: int, origin: int
) -> list[_Part] | None:
    """The sorties from a dock, by the dock where they end."""
    docks, all_ = list(chargers), list(chargers.values())
    i = docks.index(origin)
    is_alike = all(np.array_equal(each.times_ms, all_[0].times_ms) for each in all_)
    parts, count = [], 0
    for sets, times_ms, drains in _layers(paths, chargers, marks, origin):
        count += len(sets)
        if count > MOST_SETS:
            return None
        for j, dock in enumerate(docks):
            drain = drains[j].astype(np.int64)
            if is_alike:
                least = service_costs(all_[i], chargers[dock].floor + drain)
            else:
                least = costs_at_least(all_, i, j, drain)
            is_open = (times_ms[j] < _FAR) & (drain < _FAR) & (least < UNREACHABLE_MS)
            number = int(is_open.sum())
            costs_ms = times_ms[j][is_open] + least[is_open]
            ends = np.full(number, j, np.int8), sets[is_open], costs_ms
            parts.append((np.full(number, i, np.int8), *ends))
    return parts


def _layers(
    paths: PathTables, chargers: Mapping[int, Charger], marks: int, origin: int
) -> Iterator[tuple[Whole, Whole, Whole]]:
    """Sets of marks, one size after the other, with times and drains to each dock, (docks, sets).

    Only sets for which the battery lasts, to at least one dock.
    """
    docks = list(chargers)
    targets = np.array([s for s in range(len(paths.marks)) if s not in paths.docks])
    bits = paths.marks[targets].astype(np.int32)
    tables = [_Legs(_whole(paths.quickest.times_ms), origin, targets, docks)]
    tables.append(_Legs(_whole(_open_drains(paths)), origin, targets, docks))
    floors = np.array([charger.floor for charger in chargers.values()])[:, None]
    highest = chargers[origin].highest
    nothing = [table.direct[:, None] for table in tables]
    yield np.zeros(1, np.int32), nothing[0], nothing[1]
    sets = np.unique(bits)
    place = np.zeros(1 << marks, np.int32)
    place[sets] = np.arange(len(sets))
    best = [table.begun(place[bits], len(sets)) for table in tables]
    while len(sets):
        times_ms, drains = (table.to_docks(each) for table, each in zip(tables, best, strict=True))
        lasts = np.flatnonzero((drains + floors <= highest).any(axis=0))
        if len(lasts) < len(sets):
            sets, best = sets[lasts], [each.take(lasts, axis=1) for each in best]
        yield sets, times_ms.take(lasts, axis=1), drains.take(lasts, axis=1)
        place[sets] = np.arange(len(sets))
        larger = [sets[(sets & bit) == 0] | bit for bit in np.unique(bits)]
        following = np.unique(np.concatenate(larger))
        is_known = np.zeros(1 << marks, np.bool_)
        is_known[sets] = True
        best = [
            table.longer(each, following, bits, place, is_known)
            for table, each in zip(tables, best, strict=True)
        ]
        sets = following


def _whole(table: Numbers) -> Whole:
    return np.minimum(table, _FAR).astype(np.int32)


def _open_drains(paths: PathTables) -> Numbers:
    is_open = paths.least_energy.times_ms < UNREACHABLE_MS
    return np.where(is_open, paths.least_energy.drains, _FAR)


class _Legs:
    """The time, or the drain, of legs.

    Attributes:
        direct: (docks,) legs from the origin.
    """

    def __init__(self, table: Whole, origin: int, targets: NDArray[np.intp], docks: list[int]):
        self._between = table[np.ix_(targets, targets)]
        self._begin, self._back = table[origin, targets], table[targets[:, None], docks]
        self.direct = table[origin, docks]

    def begun(self, places: Whole, sets: int) -> Whole:
        """(targets, sets) paths with only one target."""
        best = np.full((len(places), sets), _FAR, np.int32)
        best[np.arange(len(places)), places] = self._begin
        return best

    def to_docks(self, best: Whole) -> Whole:
        """(docks, sets) the best path on to each dock."""
        return np.array(
            [
                (best + self._back[:, j, None]).min(axis=0, initial=_FAR)
                for j in range(self._back.shape[1])
            ]
        )

    def longer(
        self,
        best: Whole,
        sets: Whole,
        bits: Whole,
        place: Whole,
        is_known: NDArray[np.bool_],
    ) -> Whole:
        """(targets, sets) the best paths over larger sets, from those over smaller ones."""
        found = np.full((len(bits), len(sets)), _FAR, np.int32)
        for target, bit in enumerate(bits):
            has = np.flatnonzero(sets & bit)
            has = has[is_known[sets[has] ^ bit]]
            spent(ADDITION_US * len(has) * len(bits) / 4)
            before, leg = place[sets[has] ^ bit], self._between[:, target, None]
            for at in range(0, len(has), _BATCH):
                part = best.take(before[at : at + _BATCH], axis=1)
                part += leg
                found[target, has[at : at + _BATCH]] = part.min(axis=0, initial=_FAR)
        return found
