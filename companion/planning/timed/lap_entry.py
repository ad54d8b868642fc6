"""Finds the quickest path into a lap, with the clocks as they are now, by label setting.

Labels are paths from the start, taken in the order of their cost. A label is dropped if an earlier
one leads to the same state and none of its clocks shows more. A path may end where a lap admits its
clocks. For the next lap, the search continues from where it stopped.
"""

from __future__ import annotations

import heapq
from collections import defaultdict
from collections.abc import Iterator
from contextlib import suppress
from itertools import accumulate, islice
from typing import NamedTuple

from companion.errors import SearchLimit
from companion.ltl.bitsets import indices
from companion.planning.timed.label_budget import LabelBudget
from companion.planning.timed.laps import LapEntries, TimedLap
from companion.planning.timed.pareto_set import ParetoSet
from companion.planning.timed.timed_product import Clocks, TimedProduct
from companion.planning.timed.timed_step import TimedStep
from companion.slices import spent

MOST_PATHS = 200
MOST_LOOKED_AT = 2_000
_STEP_US = 2.0


class _Label(NamedTuple):
    """A path from the start."""

    cost_ms: int
    state: int
    clocks: Clocks
    before: _Label | None
    step: TimedStep | None

    @property
    def steps(self) -> list[TimedStep]:
        """The steps from the start on."""
        found: list[TimedStep] = []
        here: _Label | None = self
        while here is not None and here.step is not None:
            found.append(here.step)
            here = here.before
        return found[::-1]


class LapEntry(NamedTuple):
    """A path into a lap, and the place in the lap of the first step after it."""

    prefix: list[TimedStep]
    prefix_ms: int
    lap: TimedLap
    place: int

    @property
    def round(self) -> tuple[TimedStep, ...]:
        """The steps of the lap, from that place on."""
        return self.lap.steps[self.place :] + self.lap.steps[: self.place]


class LapEntrySearch:
    """The paths from the start of a problem that keep all bounds.

    Args:
        graph: the product.
        has_unread: whether a plan has to begin with a step, because its first letter contains what
            no other contains.
        budget: the budget of labels.
    """

    def __init__(self, graph: TimedProduct, has_unread: bool, budget: LabelBudget) -> None:
        self._graph, self._has_unread, self._budget = graph, has_unread, budget
        self._known: dict[int, ParetoSet] = defaultdict(ParetoSet)
        self._taken: list[_Label] = []
        self._pending: list[tuple[int, int, _Label]] = []
        self._count = 0
        for node in graph.product.initial:
            state = graph.product.state_of[node]
            if graph.can_begin(state):
                self._push(_Label(0, state, graph.start, None, None))

    @property
    def can_begin(self) -> bool:
        """Whether no bound is broken, or certain to be broken."""
        return bool(self._pending or self._taken)

    def reached(self) -> frozenset[int] | None:
        """The states that paths lead to; None if there are too many paths to look at them all."""
        with suppress(SearchLimit):
            if next(islice(self._labels(), MOST_LOOKED_AT, None), None) is None:
                return frozenset(label.state for label in self._taken)
        return None

    def into(self, laps: list[TimedLap]) -> LapEntry | None:
        """The best path into one of some laps; None if there is none.

        It is the quickest one. In flight it is the one for which the largest age of a mark is the
        least, among those that take at most a lap longer (as in `builtin/fair_entry.py`).

        Raises:
            SearchLimit: the budget is not sufficient.
        """
        entries = self.all_into(laps)
        best = next(entries, None)
        if best is None or not self._graph.product.waiting_since_ms:
            return best
        most_ms, age_ms = best.prefix_ms + best.lap.cost_ms, self._worst_age_ms(best)
        with suppress(SearchLimit):
            for entry in islice(entries, MOST_PATHS):
                if entry.prefix_ms > most_ms:
                    break
                own_ms = self._worst_age_ms(entry)
                if own_ms < age_ms:
                    best, age_ms = entry, own_ms
        return best

    def trimmed(self, entry: LapEntry) -> list[TimedStep]:
        """The path into a lap, with no charge higher than necessary."""
        charges = self._graph.charges
        if charges is None:
            return entry.prefix
        latest = entry.lap.latest[entry.place][-1]
        return charges.trimmed_path(entry.prefix, latest, self._graph.all_actions)

    def _worst_age_ms(self, entry: LapEntry) -> int:
        """The largest age of a mark at the moment when a plan meets it first."""
        product = self._graph.product
        steps = (*entry.prefix, *entry.round)
        spent(_STEP_US * len(steps))
        met_ms: dict[int, int] = {}
        for step, passed_ms in zip(steps, accumulate(s.cost_ms for s in steps), strict=True):
            for mark in indices(product.marks[step.node]):
                met_ms.setdefault(mark, passed_ms)
        since_ms = enumerate(product.waiting_since_ms)
        return max(met_ms[mark] - since for mark, since in since_ms)

    def all_into(self, laps: list[TimedLap]) -> Iterator[LapEntry]:
        """Every undominated path into one of some laps, the quickest first."""
        entries = LapEntries(laps)
        for label in self._labels():
            if self._has_unread and label.before is None:
                continue
            for lap, place in entries.at(label.state, label.clocks):
                yield LapEntry(label.steps, label.cost_ms, lap, place)

    def _labels(self) -> Iterator[_Label]:
        """All labels, the quickest first."""
        number = 0
        while number < len(self._taken) or self._advance():
            yield self._taken[number]
            number += 1

    def _advance(self) -> bool:
        """Takes the next label; returns whether there was one."""
        while self._pending:
            _, _, label = heapq.heappop(self._pending)
            is_first = label.before is None and self._has_unread
            if not is_first and not self._is_new(label):
                continue
            self._taken.append(label)
            steps = self._graph.steps(label.state)
            self._budget.take(len(steps))
            for step in steps:
                clocks = self._graph.after(label.clocks, step, label.before is None)
                if clocks is not None:
                    cost_ms = label.cost_ms + step.cost_ms
                    self._push(_Label(cost_ms, step.end, clocks, label, step))
            return True
        return False

    def _push(self, label: _Label) -> None:
        self._count += 1
        heapq.heappush(self._pending, (label.cost_ms, self._count, label))

    def _is_new(self, label: _Label) -> bool:
        alike = self._known[label.state]
        self._budget.take(0, len(alike))
        return alike.add(label.clocks)
