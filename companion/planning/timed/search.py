"""The best lasso that keeps the time bounds of a task: shortest lap, then shortest prefix.

1. An automaton reads a bounded line without its bound, and a clock reads the bound
   (`timed_product.py`). The search is exact, with generalized acceptance and with clocks as labels
   (`lassos.py`). It may take long, so there is a budget of labels.
2. On a battery, the best plan without bounds is used if it keeps them. Otherwise the charge is one
   more label, with a few levels to charge to (`charge_levels.py`), including those of that plan.
3. If the budget ends before a lap is found, it is unknown whether there is one. If it ends later,
   it is unknown how far that lap is from the shortest.

Whether deadlines of this kind can be kept for ever is PSPACE-complete even for one vehicle: Ho and
Ouaknine, The cyclic-routing UAV problem is PSPACE-complete, FoSSaCS 2015.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace

from companion.errors import SearchLimit
from companion.planning.builtin.product import Product
from companion.planning.builtin.search import accepting_components
from companion.planning.effort import Effort
from companion.planning.energy.search import BatterySearch
from companion.planning.lasso import Problem, Solution
from companion.planning.time_check import time_fault
from companion.planning.timed.bound_readings import may_any_run
from companion.planning.timed.charge_levels import LEVELS, levels_of
from companion.planning.timed.component import TimedComponent
from companion.planning.timed.known_laps import KnownLaps
from companion.planning.timed.label_budget import ADVICE
from companion.planning.timed.lassos import TimedLassos
from companion.planning.timed.timed_product import TimedProduct


class TimedSearch:
    """Plans that keep time bounds, from any state of one mission.

    Args:
        untimed: plans problems without time bounds.

    Attributes:
        known: laps that were found before.
    """

    def __init__(self, untimed: BatterySearch) -> None:
        self._untimed = untimed
        self.known = KnownLaps()

    def costs_have_changed(self) -> None:
        """Notes that costs have changed: what was found before may no longer be the best."""
        self.known.are_best = False

    def is_solvable(self, problem: Problem, effort: Effort) -> bool | None:
        """Whether there is a lasso; None if a search reaches its limit."""
        if not problem.clocks_ms:
            return self._untimed.is_solvable(problem, effort)
        try:
            return next(self.solutions(problem, effort), None) is not None
        except SearchLimit:
            return None

    def solutions(self, problem: Problem, effort: Effort) -> Iterator[Solution]:
        """Lassos, each better than the one before; none if there is none.

        If a flight is late, it may use up the margin that plans keep.

        Raises:
            SearchLimit: the product has too many states, or the budget ended before any was found.
        """
        if not problem.clocks_ms or not may_any_run(problem):
            yield from self._untimed.solutions(problem, effort)
            return
        product = self._untimed.plain.product(problem, effort, min_goals=sys.maxsize)
        if problem.energy is None:
            yield from self._searched(problem, product, effort)
        else:
            yield from self._on_a_battery(problem, product, effort)

    def _on_a_battery(
        self, problem: Problem, product: Product, effort: Effort
    ) -> Iterator[Solution]:
        """The best plan for the battery, if it keeps the bounds; otherwise one with few levels.

        Raises:
            SearchLimit: as in `solutions`, or a plan with other levels of charge may exist.
        """
        *_, best = None, *self._untimed.within(product, problem, effort)
        if best is None:
            return
        if time_fault(_as_planned(problem), best.lasso) is None:
            yield best
            return
        has_found = False
        self.known.keep_loop(best.lasso.loop)  # its levels are not among the few
        in_lap, before_lap = levels_of(best.lasso.loop), levels_of(best.lasso.prefix)
        for solution in self._searched(problem, product, effort, in_lap, before_lap):
            has_found = True
            yield replace(solution, bound_ms=min(best.bound_ms, solution.cost_ms))
        if not has_found and self.is_solvable(replace(problem, energy=None), effort) is not False:
            raise SearchLimit(f"{LEVELS} levels of charge, with bounds in time", ADVICE)

    def _searched(
        self,
        problem: Problem,
        product: Product,
        effort: Effort,
        in_lap: frozenset[int] = frozenset(),
        before_lap: frozenset[int] = frozenset(),
    ) -> Iterator[Solution]:
        """Searches by label setting.

        Args:
            problem: a problem with time bounds.
            product: its product.
            effort: the limits of the search.
            in_lap: levels to charge to, in addition to a few.
            before_lap: more of them for the path into a lap. They may depend on the charge now, as
                laps do not.
        """
        components = accepting_components(product)
        if not components:
            return
        has_found, limit = False, None
        for is_late in (False, True) if any(problem.clocks_ms) else (False,):
            graph = TimedProduct(problem, product, is_late, levels=in_lap)
            if not graph.bounds:
                yield from self._untimed.solutions(problem, effort)
                return
            parts = [TimedComponent(graph, nodes) for nodes in components]
            into = graph
            if not before_lap <= in_lap or (problem.energy is not None and problem.energy.is_short):
                levels = before_lap | in_lap
                into = TimedProduct(problem, product, is_late, in_loop=False, levels=levels)
            try:
                lassos = TimedLassos(problem, graph, parts, effort, self.known, into)
                for solution in lassos.solutions():
                    has_found = True
                    yield solution
            except SearchLimit as reached:
                limit = limit or reached
            if has_found:
                return
        if limit is not None:
            raise limit


def _as_planned(problem: Problem) -> Problem:
    """The problem with the limits that plans keep."""
    conjuncts = (
        each
        if each.bound is None
        else replace(each, bound=replace(each.bound, limit_ms=each.bound.planned_ms))
        for each in problem.conjuncts
    )
    return replace(problem, conjuncts=tuple(conjuncts))
