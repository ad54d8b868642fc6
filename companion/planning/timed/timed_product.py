"""A product with the clocks of the lines that have a time bound.

A clock is a label in addition to the states: smaller is better, and best is a clock that stands
still. The effect of a step on clocks is monotone: smaller clocks lead to smaller ones. So of two
paths to the same state, one is at least as good as the other if none of its clocks shows more.

A position is cut if it is reached with a clock above its limit, or if the shortest path from it to
the clock's goal takes longer than the time left.

Source: Irnich and Desaulniers, Shortest path problems with resource constraints, 2005.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from companion.ltl.formula import Formula, atoms
from companion.ltl.semantics import holds
from companion.ltl.time_bounds import Response, Revisit, TimeBound
from companion.planning.builtin.costs import UNREACHABLE_MS, Costs
from companion.planning.builtin.product import Product
from companion.planning.builtin.shortest_paths import cheapest_edges, whole
from companion.planning.domain import Action, duration_ms
from companion.planning.effort import DIJKSTRA_STEP_US
from companion.planning.lasso import Problem
from companion.planning.timed.bound_readings import BoundReading, Letters, reading_of
from companion.planning.timed.charge_levels import ChargeLevels
from companion.planning.timed.timed_step import TimedStep
from companion.slices import spent

STANDS = -1
"""What a clock that does not run shows."""

Clocks = tuple[int, ...]
"""What each clock shows, in milliseconds."""

_NODE_US, _EDGE_US, _READING_US, _ACTION_US = 1.0, 0.1, 10.0, 1.0


class TimedProduct:
    """A product and its clocks.

    Attributes:
        product: with all one-shot goals in it.
        bounds: the bounds of the clocks that may ever run.
        limits_ms: the limits that plans keep, by clock.
        start: what the clocks show now. On a battery the last one is what is missing from a full
            one.
        least: the least that each clock ever shows.

    Args:
        problem: a problem with time bounds.
        product: the product of the problem.
        is_late: whether a clock that runs now may use up the margin that plans keep.
        in_loop: whether it is for loops, not for the path into one.
        levels: levels to charge to, in addition to a few.
    """

    def __init__(
        self,
        problem: Problem,
        product: Product,
        is_late: bool = False,
        in_loop: bool = True,
        levels: frozenset[int] = frozenset(),
    ) -> None:
        spent(_NODE_US * product.nodes + _EDGE_US * len(product.ends))
        self.product = product
        self._problem = problem
        self._letters = Letters(product)
        actions = [duration_ms(action) for action in problem.actions]
        self._durations = np.array(actions, np.int64)[product.actions]
        self._sources = np.repeat(np.arange(product.nodes), np.diff(product.first))
        ends = product.ends.astype(np.int64)
        self._forward = cheapest_edges(self._sources, ends, self._durations, product.nodes)
        self._steps: dict[int, list[TimedStep]] = {}
        self._first_kinds: dict[int, list[int]] = {}
        clocks = problem.clocks_ms or (None,) * len(problem.conjuncts)
        self.bounds: list[TimeBound] = []
        start: list[int] = []
        kinds: list[NDArray[np.int8]] = []
        for conjunct, elapsed_ms in zip(problem.conjuncts, clocks, strict=True):
            bound = conjunct.bound
            if bound is None:
                continue
            own = self._read(bound)
            if elapsed_ms is None and not self._can_begin(bound, own):
                continue
            in_hand_ms = bound.limit_ms - bound.planned_ms if is_late else 0
            start.append(STANDS if elapsed_ms is None else max(0, elapsed_ms - in_hand_ms))
            self.bounds.append(bound)
            kinds.append(own)
        self.start = tuple(start)
        self.limits_ms = tuple(bound.planned_ms for bound in self.bounds)
        self.least = tuple(0 if isinstance(b, Revisit) else STANDS for b in self.bounds)
        self._goals = [np.flatnonzero(own == BoundReading.GOAL) for own in kinds]
        latest = [self._latest(i) for i in range(len(self.bounds))]
        self.charges = None
        if problem.energy is not None:
            self.charges = ChargeLevels(problem.energy, product, in_loop, levels)
            self.start = (*self.start, self.charges.missing)
            self.limits_ms = (*self.limits_ms, self.charges.full)
            self.least = (*self.least, 0)
        if not self.bounds:
            return
        self._kinds = list(zip(*(own.tolist() for own in kinds), strict=True))
        self._latest_ms = list(zip(*(own.tolist() for own in latest), strict=True))

    # -- clocks ------------------------------------------------------------------------------------

    def after(self, clocks: Clocks, step: TimedStep, is_first: bool = False) -> Clocks | None:
        """The clocks after a step; None if one of them is late, or certain to become late.

        Args:
            clocks: the clocks before the step.
            step: the step, which leads to a state.
            is_first: whether its end is the first position of a plan.
        """
        state, took_ms = step.end, step.duration_ms
        kinds = self._first(state) if is_first and self._problem.unread else self._kinds[state]
        shown = []
        for elapsed, limit, kind, zero, latest in zip(
            clocks, self.limits_ms, kinds, self.least, self._latest_ms[state], strict=False
        ):
            now = elapsed
            if now >= 0:
                now += took_ms
                if now > limit:
                    return None
            if kind == BoundReading.GOAL:
                now = zero
            elif kind == BoundReading.TRIGGER and now < 0:
                now = 0
            if now > latest:
                return None
            shown.append(now)
        if self.charges is not None:
            missing = self.charges.after(clocks[-1], step)
            if missing is None:
                return None
            shown.append(missing)
        return tuple(shown)

    @property
    def all_actions(self) -> Sequence[Action]:
        """The actions of the problem."""
        return self._problem.actions

    def can_begin(self, state: int) -> bool:
        """Whether no clock is late, or certain to become late, where a plan begins."""
        latest = self._latest_ms[state]
        is_kept = self.charges is None or self.start[-1] <= self.charges.most_missing(state)
        return is_kept and all(
            now <= min(limit, last)
            for now, limit, last in zip(self.start, self.limits_ms, latest, strict=False)
        )

    def is_goal(self, clock: int, state: int) -> bool:
        """Whether the goal of a clock holds at a state."""
        return bool(self._kinds[state][clock] == BoundReading.GOAL)

    def is_met(self, clock: int, step: TimedStep) -> bool:
        """Whether a step leads to the goal of a clock; for the battery, whether it charges."""
        if clock == len(self.bounds):
            return step.charge is not None
        return self.is_goal(clock, step.end)

    def reading(self, state: int) -> tuple[int, ...]:
        """What a state does with each clock; on a battery also what may be missing there."""
        kinds = tuple(map(int, self._kinds[state]))
        return kinds if self.charges is None else (*kinds, self.charges.most_missing(state))

    def goals(self, clock: int) -> NDArray[np.intp]:
        """The nodes where the goal of a clock holds."""
        return self._goals[clock]

    # -- steps and paths ---------------------------------------------------------------------------

    def steps(self, state: int) -> list[TimedStep]:
        """The steps that leave a state."""
        found = self._steps.get(state)
        if found is None:
            product = self.product
            span = slice(product.first[state], product.first[state + 1])
            ends = product.ends[span].tolist()
            plain = [
                TimedStep(action, cost_ms, took_ms, product.state_of[end], end)
                for action, cost_ms, took_ms, end in zip(
                    product.actions[span].tolist(),
                    product.costs[span].tolist(),
                    self._durations[span].tolist(),
                    ends,
                    strict=True,
                )
            ]
            found = self._steps[state] = plain
            if self.charges is not None:
                actions = self._problem.actions
                each = (self.charges.steps(step, actions[step.action]) for step in plain)
                found = self._steps[state] = [step for steps in each for step in steps]
            spent(_EDGE_US * len(found) * 10)
        return found

    def durations_from(self, nodes: Sequence[int] | NDArray[np.intp]) -> Costs:
        """(nodes,) the least time to each node from any of the given nodes."""
        return self._least_times(self._forward, nodes)

    def durations_to(self, nodes: Sequence[int] | NDArray[np.intp]) -> Costs:
        """(nodes,) the least time from each node to any of the given nodes."""
        return self._least_times(self._backward, nodes)

    def _least_times(self, matrix: csr_array, nodes: Sequence[int] | NDArray[np.intp]) -> Costs:
        spent(DIJKSTRA_STEP_US * self.product.dijkstra_steps)
        if not len(nodes):
            return np.full(self.product.nodes, UNREACHABLE_MS)
        return whole(dijkstra(matrix, indices=nodes, min_only=True))

    @cached_property
    def _backward(self) -> csr_array:
        return self._forward.T.tocsr()

    def _latest(self, clock: int) -> NDArray[np.int64]:
        """(nodes,) the most that the clock may show after a node is read."""
        product = self.product
        to_goal = self.durations_to(self._goals[clock])
        least = np.full(product.nodes, UNREACHABLE_MS)
        np.minimum.at(least, self._sources, self._durations + to_goal[product.ends])
        latest: NDArray[np.int64] = np.maximum(STANDS, self.limits_ms[clock] - least)
        return latest

    # -- readings ----------------------------------------------------------------------------------

    def _read(self, bound: TimeBound) -> NDArray[np.int8]:
        """(nodes,) what each node does with the clock of a bound."""
        kinds = np.full(self.product.nodes, BoundReading.NOTHING, np.int8)
        if isinstance(bound, Response):
            kinds[self._letters.where(bound.trigger)] = BoundReading.TRIGGER
        kinds[self._letters.where(bound.goal)] = BoundReading.GOAL
        return kinds

    def _can_begin(self, bound: TimeBound, kinds: NDArray[np.int8]) -> bool:
        """Whether a clock that stands still may ever run.

        That of a revisit stands still if an event has met its goal, up to the next position.
        """
        if not isinstance(bound, Response):
            return isinstance(bound, Revisit)
        unread = self._problem.unread & frozenset(atoms(bound.trigger))
        return bool(unread) or bool((kinds == BoundReading.TRIGGER).any())

    def _first(self, state: int) -> list[int]:
        """What a state does with each clock, as the first position of a plan."""
        found = self._first_kinds.get(state)
        if found is None:
            letter = self._letters.of(state) | self._problem.unread

            def is_true(formula: Formula) -> bool:
                return holds(formula, [], [letter])

            found = self._first_kinds[state] = [reading_of(bound, is_true) for bound in self.bounds]
        return found
