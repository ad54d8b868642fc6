"""One-shot goals: finds the best order to meet, before the loop, what has to be met once.

`F at(A) & F at(B) & ...` doubles the product with each site. So one-shot goals are left out of the
product. A prefix is then a path from the start, over a node of each goal, to a node of a loop. One
more target represents the loop and leads back to the start; then the path is a tour, and is found
like other tours (`gtsp.py`): exactly for few goals, by local search for many.

The goals are met before the loop begins. That the loop might meet some of them in its first lap is
not used, so such a plan is proved optimal only if its loop is a rest (`search.py`).
"""

from __future__ import annotations

import numpy as np

from companion.errors import SearchLimit
from companion.planning.builtin.costs import UNREACHABLE_MS, Costs
from companion.planning.builtin.gtsp import tours
from companion.planning.builtin.product import Product
from companion.planning.builtin.shortest_paths import Edge, ShortestPaths
from companion.planning.effort import Effort


class OneShotGoals:
    """The paths from the start, over all one-shot goals, to a loop.

    Args:
        product: the product, with the goals.
        paths: the shortest paths in the product.
        loop_costs: cost of the loop that begins at each node, (nodes,); UNREACHABLE_MS if none
            does.
        effort: the limits of the search.

    Raises:
        SearchLimit: too many nodes meet goals.
    """

    def __init__(
        self,
        product: Product,
        paths: ShortestPaths,
        loop_costs: Costs,
        effort: Effort,
    ) -> None:
        goals, initial = product.one_shot_goals, product.initial
        self._paths = paths
        self._targets = sorted(set().union(*goals))
        if len(self._targets) * product.dijkstra_steps > effort.dijkstra_steps:
            raise SearchLimit(
                f"{effort.dijkstra_steps:,} steps of Dijkstra searches, one for each of "
                f"{len(self._targets):,} product states that meet a goal"
            )
        to_targets = paths.costs_to(self._targets)
        self._to_targets = to_targets
        size = len(self._targets)
        between = np.full((size + 1, size + 1), UNREACHABLE_MS)
        between[:size, :size] = to_targets[:, self._targets].T
        starts = to_targets[:, initial]
        for i, target in enumerate(self._targets):
            between[i, i] = paths.cycle_ms(target, to_targets[i])
            starts[i, [node == target for node in initial]] = between[i, i]
        between[size, :size] = starts.min(axis=1)
        ends = paths.costs_from(self._targets) + loop_costs
        between[:size, size] = np.minimum(ends.min(axis=1), UNREACHABLE_MS)
        self._starts = [initial[i] for i in starts.argmin(axis=1)]
        self._entries = ends.argmin(axis=1)
        marks = np.zeros((size + 1, len(goals) + 1), np.bool_)
        for column, nodes in enumerate(goals):
            marks[[self._targets.index(node) for node in nodes], column] = True
        marks[size, -1] = True
        self._tours = tours(between, marks, effort.held_karp_additions)
        self.is_final = self.is_exact = self._tours.is_exact

    @property
    def cost_ms(self) -> int:
        """Cost of the best known path, including its loop."""
        return self._tours.cost_ms

    def improve(self) -> None:
        """Looks for a better path."""
        self._tours.improve()
        self.is_final = True

    def prefix(self) -> tuple[list[Edge], int]:
        """The best known path, and the node where its loop begins."""
        cycle = self._tours.cycle()
        begin = cycle.index(len(self._targets)) + 1
        first, *rest = cycle[begin:] + cycle[: begin - 1]
        here = self._starts[first]
        path: list[Edge] = []
        for place in (first, *rest):
            target = self._targets[place]
            path += self._paths.path(here, target, self._to_targets[place])
            here = target
        entry = int(self._entries[rest[-1] if rest else first])
        if entry != here:
            (to_entry,) = self._paths.costs_to([entry])
            path += self._paths.path(here, entry, to_entry)
        return path, entry
