"""The best lasso that the battery lasts for: the shortest lap, then the shortest prefix."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace

from companion.errors import SearchLimit
from companion.planning.builtin.product import Product
from companion.planning.builtin.search import Search, accepting_components
from companion.planning.effort import Effort
from companion.planning.energy.energy_product import EnergyProduct
from companion.planning.energy.known_loops import KnownLoops
from companion.planning.energy.lassos import EnergyLassos
from companion.planning.lasso import Problem, Solution
from companion.planning.objective import Objective


class BatterySearch:
    """Plans that the battery lasts for, from any state of one mission.

    Args:
        plain: plans problems without energy.

    Attributes:
        plain: as given.
        loops: loops that were found before.
    """

    def __init__(self, plain: Search) -> None:
        self.plain = plain
        self.loops = KnownLoops()

    def is_solvable(self, problem: Problem, effort: Effort) -> bool | None:
        """Whether there is a lasso; None if the search reaches its limit."""
        if problem.energy is None:
            return self.plain.is_solvable(problem, effort)
        try:
            found = self.solutions(problem, replace(effort, proves_laps=False))
            return next(found, None) is not None
        except SearchLimit:
            return None

    def solutions(self, problem: Problem, effort: Effort) -> Iterator[Solution]:
        """A good lasso that the battery lasts for, then the best one; none if there is none.

        Raises:
            SearchLimit: the product has too many states.
        """
        if problem.energy is None:
            yield from self.plain.solutions(problem, Objective.LAP, effort)
            return
        product = self.plain.product(problem, effort, min_goals=sys.maxsize)
        yield from self.within(product, problem, effort)

    def within(self, product: Product, problem: Problem, effort: Effort) -> Iterator[Solution]:
        """The same for a problem with energy whose product is known, whatever time bounds it has.

        Args:
            product: with all one-shot goals in it.
        """
        graph = EnergyProduct(problem, product)
        lassos = EnergyLassos(graph, self.loops, effort.proves_laps)
        yield from lassos.solutions(accepting_components(product))
