"""Finds the shortest laps through a state that keep all bounds for ever, by label setting.

A label is a path from a state, the anchor, to another one: its cost, the marks that it has met, and
its clocks. What a clock shows at the anchor is only known at the end of the lap. So each clock
begins with the least that it may show, and a label remembers when the goal of each clock was first
met. At the end, that time plus what the clock shows then has to be within the limit.

One label dominates another at the same state with the same marks if it costs no more, no clock
shows more, and no goal was first met later. Labels are taken in the order of their cost plus the
least cost of ending the lap (`lap_completion.py`), so laps are found in the order of their cost.

Source: Irnich and Desaulniers, Shortest path problems with resource constraints, 2005.
"""

from __future__ import annotations

import heapq
from collections import defaultdict
from collections.abc import Iterator
from typing import NamedTuple

from companion.planning.builtin.costs import UNREACHABLE_MS
from companion.planning.timed.component import TimedComponent
from companion.planning.timed.label_budget import LabelBudget
from companion.planning.timed.lap_completion import completion, completion_in_order
from companion.planning.timed.pareto_set import ParetoSet
from companion.planning.timed.timed_product import STANDS, Clocks, TimedProduct
from companion.planning.timed.timed_step import TimedStep

_OPEN = 1
"""Marks a clock whose goal has not been met yet."""


class _LapLabel(NamedTuple):
    """A path from the anchor.

    Attributes:
        met: the marks, as bits.
        first_met: by clock, when its goal was first met; the time passed, if it has not been met.
            On a battery the last entry is the level that is needed up to the first charge.
        is_met: the clocks whose goal was met, as bits.
    """

    cost_ms: int
    elapsed_ms: int
    state: int
    met: int
    clocks: Clocks
    first_met: Clocks
    is_met: int
    before: _LapLabel | None
    step: TimedStep | None

    @property
    def weight(self) -> tuple[int, ...]:
        """The values by which labels are compared; less is better."""
        is_open = (_OPEN if not self.is_met >> c & 1 else 0 for c in range(len(self.clocks)))
        return (self.cost_ms, *self.clocks, *self.first_met, *is_open)


MOST_ALIKE = 20
"""The most labels kept for a state and marks, if marks are met in order."""


class LapSearch:
    """Laps through one anchor.

    Attributes:
        bound_ms: a lower bound for the laps that are still to come.

    Args:
        graph: the product.
        component: the component in which laps stay.
        anchor: the state.
        budget: the budget of labels.
        barred: states that laps avoid, because the laps through them are known.
        is_in_order: whether laps meet the marks in order; then not all are found, but some quickly.
    """

    def __init__(
        self,
        graph: TimedProduct,
        component: TimedComponent,
        anchor: int,
        budget: LabelBudget,
        barred: frozenset[int] = frozenset(),
        is_in_order: bool = False,
    ) -> None:
        self._graph, self._component, self._anchor = graph, component, anchor
        self._budget, self._barred, self._is_in_order = budget, barred, is_in_order
        if is_in_order:
            self._missing_ms = completion_in_order(component, anchor, barred)
        else:
            self._missing_ms = completion(component, anchor, barred, budget.most // 2)
        self.bound_ms = self._missing_ms(anchor, 0)
        at_anchor = [graph.is_goal(clock, anchor) for clock in range(len(graph.bounds))]
        self._begun = sum(1 << clock for clock, is_goal in enumerate(at_anchor) if is_goal)

    def laps(self, below_ms: int = UNREACHABLE_MS) -> Iterator[list[TimedStep]]:
        """Laps that cost less than `below_ms`, the shortest first.

        Raises:
            SearchLimit: the budget is not sufficient.
        """
        pending: list[tuple[int, int, _LapLabel, TimedStep, int]] = []
        count = 0
        known: dict[tuple[int, int], ParetoSet] = defaultdict(ParetoSet)

        def lead_on(label: _LapLabel) -> None:
            """Notes the successors, but makes their labels later: most of them are never needed."""
            nonlocal count
            steps = self._component.steps(label.state)
            self._budget.take(len(steps))
            for step, marks in steps:
                if step.end in self._barred:
                    continue
                met = self._met(label.met, marks)
                least_ms = label.cost_ms + step.cost_ms + self._missing_ms(step.end, met)
                if least_ms < below_ms:
                    count += 1
                    heapq.heappush(pending, (least_ms, -count, label, step, met))

        lead_on(self._begin(known))
        while pending:
            self.bound_ms, _, before, step, met = heapq.heappop(pending)
            label = self._after(before, step, met)
            if label is None:
                continue
            if label.state == self._anchor and met == self._component.all and self._closes(label):
                yield _steps(label)
            elif self._is_new(label, known[label.state, met]):
                lead_on(label)
        self.bound_ms = below_ms

    def _begin(self, known: dict[tuple[int, int], ParetoSet]) -> _LapLabel:
        least = self._graph.least
        nothing = (0,) * len(least)
        label = _LapLabel(0, 0, self._anchor, 0, least, nothing, self._begun, None, None)
        self._is_new(label, known[label.state, label.met])
        return label

    def _met(self, met: int, marks: int) -> int:
        """The marks that have been met after a step that meets some."""
        return _in_order(met, marks) if self._is_in_order else met | marks

    def _is_new(self, label: _LapLabel, alike: ParetoSet) -> bool:
        """Whether no known label dominates this one; if so, it becomes known."""
        self._budget.take(0, len(alike))
        is_full = self._is_in_order and len(alike) >= MOST_ALIKE
        return not is_full and alike.add(label.weight)

    def _after(self, label: _LapLabel, step: TimedStep, met: int) -> _LapLabel | None:
        """The path with one more step; None if a clock has run out."""
        graph = self._graph
        clocks = graph.after(label.clocks, step)
        if clocks is None:
            return None
        elapsed_ms = label.elapsed_ms + step.duration_ms
        first_met, is_met = label.first_met, label.is_met
        if is_met != self._component.all_clocks:
            passed = []
            for clock, first_ms in enumerate(first_met):
                is_open = not is_met >> clock & 1
                passed.append(elapsed_ms if is_open else first_ms)
                if is_open and graph.charges is not None and clock == len(graph.bounds):
                    needed = graph.charges.needed(label.clocks[-1], step)
                    passed[-1] = max(first_ms, needed)
                if is_open and graph.is_met(clock, step):
                    is_met |= 1 << clock
            first_met = tuple(passed)
        cost_ms = label.cost_ms + step.cost_ms
        return _LapLabel(cost_ms, elapsed_ms, step.end, met, clocks, first_met, is_met, label, step)

    def _closes(self, label: _LapLabel) -> bool:
        """Whether a path back to the anchor can be flown for ever."""
        return all(
            now == STANDS or (label.is_met >> clock & 1 and now + first_ms <= limit_ms)
            for clock, (now, first_ms, limit_ms) in enumerate(
                zip(label.clocks, label.first_met, self._graph.limits_ms, strict=True)
            )
        )


def _in_order(met: int, marks: int) -> int:
    """The marks that count as met: of those met now, only the next ones in order."""
    while marks & (met + 1):
        met = met << 1 | 1
    return met


def _steps(label: _LapLabel) -> list[TimedStep]:
    steps: list[TimedStep] = []
    here: _LapLabel | None = label
    while here is not None and here.step is not None:
        steps.append(here.step)
        here = here.before
    return steps[::-1]
