"""Finds the quickest path to a loop with the charge that there is, charging where needed.

A label does not fix how far the battery was charged. It stores the last dock, the energy used
since, and the lowest level after that dock that satisfies every floor passed since. The level is
fixed at the next dock, or at the end, as low as the floors allow. Arriving with more is never
quicker, because a battery charges the slower the fuller it is.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from companion.planning.builtin.costs import UNREACHABLE_MS
from companion.planning.charger import Charger
from companion.slices import spent

_LABEL_US, _COMPARISON_US, _LEG_US = 2.0, 0.7, 3.0


@dataclass(frozen=True, slots=True)
class FlightLeg:
    """An edge that is not a charge."""

    end: int
    time_ms: int
    drain: int


@dataclass(frozen=True, slots=True)
class ChargeLeg:
    """An edge on which the vehicle lands, charges, and takes off."""

    end: int
    charger: Charger


@dataclass(frozen=True, slots=True)
class EnergyGraph:
    """The states of a vehicle, the edges between them, and the least level at each.

    Attributes:
        legs: by node, in the order in which ties are broken.
        charges: by node, in the same order.
        floors: by node, the least level there.
    """

    legs: Sequence[Sequence[FlightLeg]]
    charges: Sequence[Sequence[ChargeLeg]]
    floors: Sequence[int]


@dataclass(frozen=True, slots=True)
class Step:
    """A leg of a path.

    Attributes:
        number: its index among the legs of its node, or among its charges.
        departure: the level after taking off; None for a leg that is not a charge.
    """

    node: int
    number: int
    departure: int | None = None


@dataclass(frozen=True, slots=True)
class LoopApproach:
    """A path.

    Attributes:
        end: the node where it ends.
        level: the level there.
    """

    steps: tuple[Step, ...]
    time_ms: int
    end: int
    level: int


@dataclass(frozen=True, slots=True)
class ApproachGoal:
    """A node where a path may end.

    Attributes:
        required: the level required there.
    """

    node: int
    required: int


@dataclass(slots=True, eq=False)
class _Label:
    """A path to a node, as far as it is fixed: without the level of its last charge.

    Attributes:
        fixed_ms: its time without the last charge.
        used: energy used since the last charge.
        least: the level after the last charge that the floors since then require.
        level: the level after the last charge, if it cannot be chosen: at the beginning.
        charger, arrival: the last charger, and the level on arrival there.
    """

    node: int
    fixed_ms: int
    used: int
    least: int
    before: _Label | None
    number: int
    level: int | None = None
    charger: Charger | None = None
    arrival: int = 0
    is_charge: bool = False

    def departure(self, needed: int) -> int | None:
        """The level after the last charge for which this one is left now; None if impossible."""
        wanted = max(self.least, needed + self.used)
        if self.charger is None:
            assert self.level is not None
            return self.level if wanted <= self.level else None
        wanted = max(wanted, self.arrival - self.charger.landing - self.charger.take_off)
        return wanted if wanted <= self.charger.highest else None

    def time_ms(self, needed: int) -> int:
        """Its time, if this level has to be left now."""
        departure = self.departure(needed)
        if departure is None:
            return UNREACHABLE_MS
        if self.charger is None:
            return self.fixed_ms
        times_ms = self.charger.times_ms
        begin = self.arrival - self.charger.landing
        return self.fixed_ms + int(times_ms[departure + self.charger.take_off] - times_ms[begin])

    def dominates(self, other: _Label) -> bool:
        """Whether it can do everything that the other can, in no more time."""
        if self.charger is None or other.charger is None:
            is_no_later = self.time_ms(0) <= other.time_ms(0)
            if self.charger is None:  # at least as much left as the other can have
                most = self.level - self.used if self.level is not None else 0
                return is_no_later and most >= other.most_left
            return False
        offsets = (
            each.fixed_ms - int(each.charger.times_ms[each.arrival - each.charger.landing])
            for each in (self, other)
            if each.charger is not None
        )
        mine, theirs = offsets
        alike = self.charger.times_ms is other.charger.times_ms
        no_worse = self.charger.take_off <= other.charger.take_off
        return (
            alike
            and no_worse
            and mine <= theirs
            and self.used <= other.used
            and self.least <= other.least
        )

    def after(self, leg: FlightLeg, number: int) -> _Label:
        """The path with one more leg, given by its number."""
        return _Label(
            leg.end,
            self.fixed_ms + leg.time_ms,
            self.used + leg.drain,
            self.least,
            self,
            number,
            self.level,
            self.charger,
            self.arrival,
        )

    def charged(self, charge: ChargeLeg, number: int) -> _Label | None:
        """The path with one more charge; None if the vehicle cannot land on the dock."""
        charger = charge.charger
        departure = self.departure(charger.floor)
        if departure is None:
            return None
        fixed_ms = self.time_ms(charger.floor) + charger.overhead_ms
        left = departure - self.used
        return _Label(charge.end, fixed_ms, 0, 0, self, number, None, charger, left, is_charge=True)

    @property
    def most_left(self) -> int:
        """The highest possible level now."""
        highest = self.charger.highest if self.charger is not None else (self.level or 0)
        return highest - self.used


class _OpenList:
    """Waiting labels, by time; each may be continued, and may also end at its node."""

    def __init__(self, graph: EnergyGraph, goals: Sequence[ApproachGoal]) -> None:
        self._graph = graph
        self._goals: dict[int, list[tuple[int, int]]] = {}
        for number, goal in enumerate(goals):
            self._goals.setdefault(goal.node, []).append((number, goal.required))
        self._pending: list[tuple[int, int, int | None, _Label]] = []
        self._count = 0

    def push(self, label: _Label) -> None:
        """Adds a label that can keep the floor of its node."""
        floor = self._graph.floors[label.node]
        label.least = max(label.least, floor + label.used)
        self._add(label.time_ms(floor), None, label)
        for number, required in self._goals.get(label.node, ()):
            self._add(label.time_ms(required), number, label)

    def pop(self) -> tuple[_Label, int | None] | None:
        """The earliest label, and the goal if its path ends there; None if there are no labels."""
        if not self._pending:
            return None
        _, _, goal, label = heapq.heappop(self._pending)
        return label, goal

    def _add(self, time_ms: int, goal: int | None, label: _Label) -> None:
        if time_ms < UNREACHABLE_MS:
            heapq.heappush(self._pending, (time_ms, self._count, goal, label))
            self._count += 1


def approach(
    graph: EnergyGraph, starts: Sequence[int], level: int, required: Mapping[int, int]
) -> LoopApproach | None:
    """The quickest path from some nodes to one of others; None if there is none.

    Args:
        graph: all its chargers should charge alike, otherwise the path may not be the quickest.
        starts: where it may begin.
        level: the level at the beginning.
        required: by node where it may end, the level required there.
    """
    goals = [ApproachGoal(node, needed) for node, needed in required.items()]
    return next((path for _, path in quickest_paths(graph, starts, level, goals)), None)


def quickest_paths(
    graph: EnergyGraph, starts: Sequence[int], level: int, goals: Sequence[ApproachGoal]
) -> Iterator[tuple[int, LoopApproach]]:
    """The quickest path to each goal that can be reached, with the goal's number, in order of time.

    Args:
        graph: all its chargers should charge alike, otherwise the paths may not be the quickest.
        starts: where they may begin.
        level: the level at the beginning.
        goals: where they may end.
    """
    pending, left = _OpenList(graph, goals), set(range(len(goals)))
    for start in starts:
        pending.push(_Label(start, 0, 0, 0, None, -1, level=level))
    known: dict[int, list[_Label]] = {}
    while left and (popped := pending.pop()) is not None:
        label, goal = popped
        if goal is not None:
            if goal in left:
                left.remove(goal)
                yield goal, _read(label, goals[goal].required)
            continue
        alike = known.setdefault(label.node, [])
        spent(_LABEL_US + _COMPARISON_US * len(alike))
        if any(each.dominates(label) for each in alike):
            continue
        alike.append(label)
        legs, charges = graph.legs[label.node], graph.charges[label.node]
        spent(_LEG_US * (len(legs) + len(charges)))
        for number, leg in enumerate(legs):
            pending.push(label.after(leg, number))
        for number, charge in enumerate(charges):
            if (charged := label.charged(charge, number)) is not None:
                pending.push(charged)


def _read(label: _Label, needed: int) -> LoopApproach:
    """The path of a label, with its levels."""
    end, time_ms = label.node, label.time_ms(needed)
    departure = label.departure(needed)
    assert departure is not None
    level = departure - label.used
    steps: list[Step] = []
    here: _Label | None = label
    while here is not None and here.before is not None:
        if here.is_charge:
            steps.append(Step(here.before.node, here.number, departure))
            departure = here.before.departure(here.charger.floor if here.charger else 0)
        else:
            steps.append(Step(here.before.node, here.number))
        here = here.before
    return LoopApproach(tuple(steps[::-1]), time_ms, end, level)
