"""Sorties: stretches from one charge to the next, over stops that meet marks.

For each dock, each set of marks and each dock there is a sortie of least time and one of least
drain, by Held and Karp's dynamic programme. They are nearly always one and the same, as time and
drain belong to the same routes. Where they are not, their least time with their least drain is a
bound for whatever lies between them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

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
"""Bits below a key's major part, for drains; times are below 2^38 ms."""
_MAJOR_DRAIN = 38
_SET_US = 8.0


@dataclass(frozen=True, eq=False)
class WayTable:
    """Ways between stops, (N, N).

    Attributes:
        times_ms: UNREACHABLE_MS without a way.
        drains: in whole units.
    """

    times_ms: Costs
    drains: Units

    def keys(self, of_ways: NDArray[np.int64]) -> NDArray[np.int64]:
        """Keys of the ways by which they are compared; _UNREACHABLE without a way."""
        return np.where(self.times_ms < UNREACHABLE_MS, of_ways, _UNREACHABLE)


@dataclass(frozen=True, eq=False)
class WayTables:
    """The ways between stops: targets of the marks, and docks.

    Attributes:
        quickest: no way takes less time.
        thriftiest: no way takes less energy; mostly they are the same.
        marks: (N,) bits that each stop meets; 0 for a dock that meets none.
        docks: stops that are not passed without a charge.
    """

    quickest: WayTable
    thriftiest: WayTable
    marks: NDArray[np.int64]
    docks: frozenset[int] = frozenset()

    @property
    def sets(self) -> int:
        """The number of sets of marks."""
        return 1 << int(np.bitwise_or.reduce(self.marks, initial=0)).bit_length()

    def served(self, chargers: Mapping[int, Charger]) -> list[int]:
        """The docks, and the stops for which a battery lasts, from one of them to another one."""
        there = np.full(len(self.marks), -_UNREACHABLE)  # the most that may be left at each stop
        back = np.full(len(self.marks), _UNREACHABLE)  # the least with which a dock is reached
        for stop, charger in chargers.items():
            drains = np.where(self.thriftiest.times_ms < UNREACHABLE_MS, self.thriftiest.drains, 0)
            is_open = self.thriftiest.times_ms < UNREACHABLE_MS
            left = np.where(is_open[stop], charger.highest - drains[stop], -_UNREACHABLE)
            needed = np.where(is_open[:, stop], charger.floor + drains[:, stop], _UNREACHABLE)
            there, back = np.maximum(there, left), np.minimum(back, needed)
        is_served = there >= back
        is_served[list(self.docks)] = False
        is_served[list(chargers)] = True
        return [int(stop) for stop in np.flatnonzero(is_served)]


def joined(ways: WayTable, chargers: Mapping[int, Charger]) -> list[dict[int, Charger]]:
    """The docks that reach each other, on full charges at some more of them."""
    stops, all_ = list(chargers), list(chargers.values())
    floors = np.array([charger.floor for charger in all_])
    highest = np.array([charger.highest for charger in all_])
    drains, times_ms = (table[np.ix_(stops, stops)] for table in (ways.drains, ways.times_ms))
    is_near = (times_ms < UNREACHABLE_MS) & (floors + drains <= highest[:, None])
    count, group = connected_components(is_near, connection="strong")
    return [
        {stop: chargers[stop] for stop, own in zip(stops, group, strict=True) if own == number}
        for number in range(count)
    ]


class _Table:
    """From one stop, for each set of marks and each target: the best path that meets the set.

    Its keys have a major and a minor part that are minimised in this order.
    """

    def __init__(self, keys: NDArray[np.int64], ways: WayTables, start: int) -> None:
        self._keys, self._start, self._marks = keys, start, ways.marks
        passed = [stop for stop in np.flatnonzero(ways.marks) if stop not in ways.docks]
        self._targets = np.array(passed, np.intp)
        self._bits = ways.marks[self._targets]
        self._between = keys[np.ix_(self._targets, self._targets)]
        self._best = np.full((ways.sets, len(self._targets)), _UNREACHABLE)
        self._fill()

    def _fill(self) -> None:
        best, bits = self._best, self._bits
        columns = np.arange(len(bits))
        np.minimum.at(best, (bits, columns), self._keys[self._start, self._targets])
        for met in range(1, len(best)):
            spent(_SET_US + ADDITION_US * len(bits) ** 2)
            here = best[met]
            if here.min(initial=_UNREACHABLE) >= _UNREACHABLE:
                continue
            onward = np.minimum((here[:, None] + self._between).min(axis=0), _UNREACHABLE)
            after = met | bits
            fresh = after != met
            np.minimum.at(best, (after[fresh], columns[fresh]), onward[fresh])

    def to(self, end: int) -> NDArray[np.int64]:
        """(sets,) the best path to a stop that meets exactly each set of marks, the stop's too."""
        before = self._up_to(end)
        own = int(self._marks[end])
        found = np.full(len(before), _UNREACHABLE)
        np.minimum.at(found, np.arange(len(before)) | own, before)
        return found

    def path(self, met: int, end: int) -> list[int]:
        """The targets on the best path to a stop that meets exactly a set, in their order."""
        before = self._up_to(end)
        own = int(self._marks[end])
        met = min((s for s in _subsets(met) if s | own == met), key=lambda s: int(before[s]))
        path: list[int] = []
        after = self._keys[self._targets, end]
        while met:
            last = int((self._best[met] + after).argmin())
            path.append(int(self._targets[last]))
            key, bits = self._best[met, last], int(self._bits[last])
            after = self._between[:, last]
            met = self._before(met, last, int(key), bits)
        return path[::-1]

    def _up_to(self, end: int) -> NDArray[np.int64]:
        """(sets,) the best path to a stop that meets exactly each set of marks before it."""
        found = np.full(len(self._best), _UNREACHABLE)
        if len(self._targets):
            found = (self._best + self._keys[self._targets, end]).min(axis=1)
        found[0] = min(found[0], self._keys[self._start, end])
        reached: NDArray[np.int64] = np.minimum(found, _UNREACHABLE)
        return reached

    def _before(self, met: int, last: int, key: int, bits: int) -> int:
        """The set that was met before the last target of a path."""
        if met == bits and self._keys[self._start, self._targets[last]] == key:
            return 0
        rest = met & ~bits
        for kept in _subsets(bits):
            before = rest | kept
            is_other = 0 < before < met
            if is_other and (self._best[before] + self._between[:, last]).min() == key:
                return before
        raise AssertionError("a path without a beginning")


def _subsets(marks: int) -> Iterator[int]:
    """All subsets of a set, itself first."""
    part = marks
    while part:
        yield part
        part = (part - 1) & marks
    yield 0


@dataclass(frozen=True, eq=False)
class SortieTimes:
    """(sets,) sorties from one dock to another: one of least time, one of least drain.

    A set that is met may have more marks than the one that is asked for.
    """

    quickest_ms: Costs
    quickest_drain: Units
    thriftiest_ms: Costs
    thriftiest_drain: Units


class Sorties:
    """All sorties from a stop.

    Args:
        ways: between the stops.
        start: the stop.
    """

    def __init__(self, ways: WayTables, start: int) -> None:
        by_time, by_drain = ways.quickest, ways.thriftiest
        quick = by_time.keys((by_time.times_ms << _MINOR) + by_time.drains)
        thrifty = by_drain.keys((by_drain.drains << _MAJOR_DRAIN) + by_drain.times_ms)
        self._tables = _Table(quick, ways, start), _Table(thrifty, ways, start)

    def to(self, end: int) -> SortieTimes:
        """The sorties to a stop, for each set of marks."""
        quick, thrifty = (_at_least(table.to(end)) for table in self._tables)
        closed, open_ = quick >= _UNREACHABLE, thrifty < _UNREACHABLE
        return SortieTimes(
            np.where(closed, UNREACHABLE_MS, quick >> _MINOR),
            np.where(closed, 0, quick & (1 << _MINOR) - 1),
            np.where(open_, thrifty & (1 << _MAJOR_DRAIN) - 1, UNREACHABLE_MS),
            np.where(open_, thrifty >> _MAJOR_DRAIN, 0),
        )

    def path(self, end: int, marks: int, is_thrifty: bool) -> list[int]:
        """The targets of a sortie that meets at least some marks, in their order."""
        table = self._tables[is_thrifty]
        exact = table.to(end)
        supersets = [s for s in range(len(exact)) if s & marks == marks]
        met = min(supersets, key=lambda s: (int(exact[s]), s))
        return table.path(met, end)


def _at_least(exact: NDArray[np.int64]) -> NDArray[np.int64]:
    """For each set the least over all sets that contain it."""
    found = exact.copy()
    size = 1
    while size < len(found):
        halves = found.reshape(-1, 2, size)
        halves[:, 0] = np.minimum(halves[:, 0], halves[:, 1])
        size *= 2
    return found
