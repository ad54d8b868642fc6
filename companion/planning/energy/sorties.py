"""Sorties: the parts of a lap from one charge to the next, over stops that meet marks.

For each pair of docks and each set of marks there is a sortie of least time and one of least drain
(energy), by Held and Karp's dynamic programme. They are nearly always the same, because time and
drain belong to the same routes. If they are not, the least time and the least drain together are a
lower bound for everything in between.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from companion.planning.builtin.costs import UNREACHABLE_MS, Costs
from companion.planning.charger import Charger
from companion.planning.effort import ADDITION_US
from companion.slices import spent

Units = NDArray[np.int64]
"""Whole units of usable energy."""
_UNREACHABLE = 1 << 60
_MINOR = 24
"""Bits below the major part of a key, for drains; times are below 2^38 ms."""
_MAJOR_DRAIN = 38
_LAYER_US = 100.0


@dataclass(frozen=True, eq=False)
class PathTable:
    """Paths between stops, (N, N).

    Attributes:
        times_ms: UNREACHABLE_MS if there is no path.
        drains: in whole units.
    """

    times_ms: Costs
    drains: Units

    def keys(self, of_paths: NDArray[np.int64]) -> NDArray[np.int64]:
        """The keys by which paths are compared; _UNREACHABLE if there is no path."""
        return np.where(self.times_ms < UNREACHABLE_MS, of_paths, _UNREACHABLE)


@dataclass(frozen=True, eq=False)
class PathTables:
    """The paths between stops: targets of the marks, and docks.

    Attributes:
        quickest: the paths of least time.
        least_energy: the paths of least energy; mostly they are the same.
        marks: (N,) the marks (bits) that each stop meets; 0 for a dock that meets none.
        docks: stops that are not passed without a charge.
    """

    quickest: PathTable
    least_energy: PathTable
    marks: NDArray[np.int64]
    docks: frozenset[int] = frozenset()

    @property
    def sets(self) -> int:
        """The number of sets of marks."""
        return 1 << int(np.bitwise_or.reduce(self.marks, initial=0)).bit_length()

    def served(self, chargers: Mapping[int, Charger]) -> list[int]:
        """The docks, and the stops that the battery can serve on a flight from dock to dock."""
        there = np.full(len(self.marks), -_UNREACHABLE)  # highest possible level at each stop
        back = np.full(len(self.marks), _UNREACHABLE)  # lowest level for reaching a dock
        for stop, charger in chargers.items():
            drains = np.where(
                self.least_energy.times_ms < UNREACHABLE_MS, self.least_energy.drains, 0
            )
            is_open = self.least_energy.times_ms < UNREACHABLE_MS
            left = np.where(is_open[stop], charger.highest - drains[stop], -_UNREACHABLE)
            needed = np.where(is_open[:, stop], charger.floor + drains[:, stop], _UNREACHABLE)
            there, back = np.maximum(there, left), np.minimum(back, needed)
        is_served = there >= back
        is_served[list(self.docks)] = False
        is_served[list(chargers)] = True
        return [int(stop) for stop in np.flatnonzero(is_served)]


def joined(paths: PathTable, chargers: Mapping[int, Charger]) -> list[dict[int, Charger]]:
    """Groups of docks that reach each other, with full charges at docks of the group."""
    stops, all_ = list(chargers), list(chargers.values())
    floors = np.array([charger.floor for charger in all_])
    highest = np.array([charger.highest for charger in all_])
    drains, times_ms = (table[np.ix_(stops, stops)] for table in (paths.drains, paths.times_ms))
    is_near = (times_ms < UNREACHABLE_MS) & (floors + drains <= highest[:, None])
    count, group = connected_components(is_near, connection="strong")
    return [
        {stop: chargers[stop] for stop, own in zip(stops, group, strict=True) if own == number}
        for number in range(count)
    ]


class _Tables:
    """For some starts, the best path for each set of marks and each last target.

    Keys have a major and a minor part, which are minimised in this order. Sets of equal size are
    processed at once, because paths only lead to larger sets.

    Args:
        keys: (tables, N, N) keys of the paths between stops.
        starts: (tables,) where the paths of each table begin.
        marks: (N,) the marks (bits) that each stop meets.
        targets: stops that meet marks and may be passed.
        sets: number of sets of marks.
    """

    def __init__(
        self,
        keys: NDArray[np.int64],
        starts: NDArray[np.intp],
        marks: NDArray[np.int64],
        targets: NDArray[np.intp],
        sets: int,
    ) -> None:
        self._targets, self._marks, self._bits = targets, marks, marks[targets]
        self._between = keys[:, targets[:, None], targets]
        self._begin = keys[np.arange(len(keys))[:, None], starts[:, None], targets]
        self._to = keys[:, targets]
        self._direct = keys[np.arange(len(keys)), starts]
        self._best = np.full((len(keys), sets, len(targets)), _UNREACHABLE)
        self._fill()

    def _fill(self) -> None:
        tables, sets, size = self._best.shape
        columns = np.arange(size)
        best = self._best.reshape(tables, -1)  # views: (tables, sets * targets)
        for table in range(tables):
            np.minimum.at(best[table], self._bits * size + columns, self._begin[table])
        for layer in _layers(sets):
            spent(_LAYER_US + ADDITION_US * tables * len(layer) * size**2)
            here = self._best[:, layer]
            onward = (here[..., None] + self._between[:, None]).min(axis=2, initial=_UNREACHABLE)
            after = layer[:, None] | self._bits
            fresh = after != layer[:, None]
            places = (after * size + columns)[fresh]
            for table in range(tables):
                np.minimum.at(best[table], places, onward[table][fresh])

    def to(self, table: int, end: int) -> NDArray[np.int64]:
        """(sets,) the best path to a stop that meets exactly each set of marks, with its own."""
        before = self._up_to(table, end)
        own = int(self._marks[end])
        found = np.full(len(before), _UNREACHABLE)
        np.minimum.at(found, np.arange(len(before)) | own, before)
        return found

    def path(self, table: int, met: int, end: int) -> list[int]:
        """The targets on the best path to a stop that meets exactly this set, in their order."""
        before = self._up_to(table, end)
        own = int(self._marks[end])
        met = min((met & ~own | kept for kept in subsets(met & own)), key=lambda s: int(before[s]))
        path: list[int] = []
        best, between, after = self._best[table], self._between[table], self._to[table, :, end]
        while met:
            last = int((best[met] + after).argmin())
            path.append(int(self._targets[last]))
            after = between[:, last]
            met = self._before(table, met, last)
        return path[::-1]

    def _up_to(self, table: int, end: int) -> NDArray[np.int64]:
        """(sets,) the best path to a stop that meets exactly each set of marks before the stop."""
        to = self._to[table, :, end]
        found = (self._best[table] + to).min(axis=1, initial=_UNREACHABLE)
        found[0] = min(found[0], self._direct[table, end])
        reached: NDArray[np.int64] = np.minimum(found, _UNREACHABLE)
        return reached

    def _before(self, table: int, met: int, last: int) -> int:
        """The set that was met before the last target of a path."""
        best, between = self._best[table], self._between[table]
        key, bits = best[met, last], int(self._bits[last])
        if met == bits and self._begin[table, last] == key:
            return 0
        rest = met & ~bits
        for kept in subsets(bits):
            before = rest | kept
            is_other = 0 < before < met
            if is_other and (best[before] + between[:, last]).min() == key:
                return before
        raise AssertionError("a path without a beginning")


@cache
def _layers(sets: int) -> list[NDArray[np.intp]]:
    """All sets of marks except the empty one and the full one, grouped by size."""
    numbers = np.arange(sets)
    sizes = np.bitwise_count(numbers)
    return [np.flatnonzero(sizes == size) for size in range(1, int(sizes.max(initial=0)))]


def subsets(marks: int) -> Iterator[int]:
    """All subsets of a set, the set itself first."""
    part = marks
    while part:
        yield part
        part = (part - 1) & marks
    yield 0


@dataclass(frozen=True, eq=False)
class SortieTimes:
    """(sets,) sorties from one dock to another: one of least time, one of least drain.

    They may meet more marks than the set for which they are given.
    """

    quickest_ms: Costs
    quickest_drain: Units
    thriftiest_ms: Costs
    thriftiest_drain: Units


class Sorties:
    """All sorties between some docks.

    Args:
        paths: the paths between the stops.
        docks: where sorties begin and end.
    """

    def __init__(self, paths: PathTables, docks: Sequence[int]) -> None:
        by_time, by_drain = paths.quickest, paths.least_energy
        quick = by_time.keys((by_time.times_ms << _MINOR) + by_time.drains)
        thrifty = by_drain.keys((by_drain.drains << _MAJOR_DRAIN) + by_drain.times_ms)
        passed = [stop for stop in np.flatnonzero(paths.marks) if stop not in paths.docks]
        keys = np.concatenate(
            [np.broadcast_to(k, (len(docks), *k.shape)) for k in (quick, thrifty)]
        )
        starts, targets = np.array([*docks, *docks], np.intp), np.array(passed, np.intp)
        self._tables = _Tables(keys, starts, paths.marks, targets, paths.sets)
        self._docks = docks

    def between(self, i: int, j: int) -> SortieTimes:
        """The sorties from one dock to another, given by their indices, for each set of marks."""
        end = self._docks[j]
        quick, thrifty = (
            _at_least(self._tables.to(self._table(i, is_thrifty), end))
            for is_thrifty in (False, True)
        )
        closed, open_ = quick >= _UNREACHABLE, thrifty < _UNREACHABLE
        return SortieTimes(
            np.where(closed, UNREACHABLE_MS, quick >> _MINOR),
            np.where(closed, 0, quick & (1 << _MINOR) - 1),
            np.where(open_, thrifty & (1 << _MAJOR_DRAIN) - 1, UNREACHABLE_MS),
            np.where(open_, thrifty >> _MAJOR_DRAIN, 0),
        )

    def path(self, i: int, j: int, marks: int, is_thrifty: bool) -> list[int]:
        """The targets of a sortie that meets at least these marks, in their order."""
        table, end = self._table(i, is_thrifty), self._docks[j]
        exact = self._tables.to(table, end)
        supersets = np.arange(len(exact)) | marks
        met = int(supersets[exact[supersets].argmin()])
        return self._tables.path(table, met, end)

    def _table(self, i: int, is_thrifty: bool) -> int:
        return i + len(self._docks) * is_thrifty


def _at_least(exact: NDArray[np.int64]) -> NDArray[np.int64]:
    """For each set, the least value over all sets that contain it."""
    found = exact.copy()
    size = 1
    while size < len(found):
        halves = found.reshape(-1, 2, size)
        halves[:, 0] = np.minimum(halves[:, 0], halves[:, 1])
        size *= 2
    return found
