"""Tours over targets: the generalised travelling salesman problem (GTSP) of a loop.

A loop of a plan is a closed walk that passes, for every acceptance mark, a node that has it: a
*target*. Between two targets it takes the shortest path, so what is left to choose is one target
for each mark and their order. With one target for each mark (a patrol) that is the travelling
salesman problem itself. Few marks are solved exactly (`held_karp.py`), many by local search
(`local_search.py`).
"""

from __future__ import annotations

from typing import Protocol

from companion.planning.builtin.costs import Costs, Marks
from companion.planning.builtin.held_karp import HeldKarp, table_additions
from companion.planning.builtin.local_search import LocalSearch


class Tours(Protocol):
    """The best tours that are known over some targets.

    Attributes:
        cost_ms: of the shortest one.
        bound_ms: no tour is shorter; 0 if nothing is known.
        is_exact: whether all costs are those of shortest tours.
    """

    cost_ms: int
    bound_ms: int
    is_exact: bool

    def improve(self) -> None:
        """Looks for shorter tours."""

    def costs_through(self, to_targets: Costs, from_targets: Costs) -> Costs:
        """Cost of the shortest tour known through each of some nodes, (V,).

        Args:
            to_targets: cost from each node to each target, (T, V).
            from_targets: cost from each target to each node, (T, V).
        """

    def cycle(self) -> list[int]:
        """The targets of the shortest tour, beginning with any of them."""

    def order_after(self, to_targets: Costs, from_targets: Costs) -> list[int]:
        """The targets of the shortest tour through a node, in the order in which they follow it.

        Args:
            to_targets: cost from the node to each target, (T,).
            from_targets: cost from each target to the node, (T,).
        """


def tours(between: Costs, marks: Marks, max_additions: int) -> Tours:
    """Tours that meet every mark, exact ones if their tables take no more additions than allowed.

    Args:
        between: cost of the shortest path with at least one edge from target to target, (T, T).
        marks: of the targets, (T, M); every mark has a target.
        max_additions: that the tables of Held and Karp may take.
    """
    is_small = table_additions(marks) <= max_additions
    return (HeldKarp if is_small else LocalSearch)(between, marks)
