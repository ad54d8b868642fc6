"""Tours over targets: the generalised travelling salesman problem (GTSP) of a loop.

A plan's loop is a closed walk that passes, for every acceptance mark, a node with that mark: a
*target*. Between two targets it takes the shortest path. So the choice is one target for each mark,
and their order. If each mark has only one target (a patrol), this is the travelling salesman
problem. Few marks are solved exactly (`held_karp.py`), many by local search (`local_search.py`).
"""

from __future__ import annotations

from typing import Protocol

from companion.planning.builtin.costs import Costs, Marks
from companion.planning.builtin.held_karp import HeldKarp, table_additions
from companion.planning.builtin.local_search import LocalSearch


class Tours(Protocol):
    """The best known tours over some targets.

    Attributes:
        cost_ms: cost of the shortest known tour.
        bound_ms: a lower bound for all tours; 0 if nothing is known.
        is_exact: whether all costs are those of shortest tours.
    """

    cost_ms: int
    bound_ms: int
    is_exact: bool

    def improve(self) -> None:
        """Looks for shorter tours."""

    def costs_through(self, to_targets: Costs, from_targets: Costs) -> Costs:
        """Cost of the shortest known tour through each of some nodes, (V,).

        Args:
            to_targets: cost from each node to each target, (T, V).
            from_targets: cost from each target to each node, (T, V).
        """

    def cycle(self) -> list[int]:
        """The targets of the shortest known tour, beginning with any of them."""

    def order_after(self, to_targets: Costs, from_targets: Costs) -> list[int]:
        """The targets of the shortest known tour through a node, in order from the node.

        Args:
            to_targets: cost from the node to each target, (T,).
            from_targets: cost from each target to the node, (T,).
        """


def tours(between: Costs, marks: Marks, max_additions: int) -> Tours:
    """Tours that meet every mark; exact ones if their tables need few enough additions.

    Args:
        between: cost of the shortest path with at least one edge from target to target, (T, T).
        marks: marks of the targets, (T, M); every mark has a target.
        max_additions: limit of the additions for the tables of Held and Karp.
    """
    is_small = table_additions(marks) <= max_additions
    return (HeldKarp if is_small else LocalSearch)(between, marks)
