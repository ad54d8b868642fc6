"""The effort of a search: limits that are counted, not timed.

So equal problems have equal answers on every machine.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Effort:
    """Limits of a search.

    Attributes:
        product_edges: edges of the product; beyond them the search is given up.
        dijkstra_steps: steps of all shortest-path searches together; there is one search for each
            target. A search takes a step for each edge of the product and 30 for each node
            (`product.dijkstra_steps`). If there are too many targets, only the nearest are looked
            at.
        held_karp_additions: additions in the tables of exact tours; beyond them local search is
            used instead.
        loop_steps: edges that the search for loops may see outside cycles of the product; beyond
            them it is not proved that no loop is better.
        time_labels: partial plans that the search with time bounds may look at.
        proves_laps: whether there is time to prove that a lap on a battery is the shortest, or how
            far it may be from that.
    """

    product_edges: int
    dijkstra_steps: int
    held_karp_additions: int
    loop_steps: int
    time_labels: int
    proves_laps: bool = False


BEFORE_FLIGHT = Effort(
    product_edges=1_000_000,
    dijkstra_steps=600_000_000,
    held_karp_additions=60_000_000,
    loop_steps=200_000,
    time_labels=1_000_000,
    proves_laps=True,
)
IN_FLIGHT = Effort(
    product_edges=80_000,
    dijkstra_steps=15_000_000,
    held_karp_additions=15_000_000,
    loop_steps=10_000,
    time_labels=60_000,
)
"""Takes well under a second, which is done in slices (slices.py)."""

PRODUCT_EDGE_US = 0.5
DIJKSTRA_STEP_US = 0.005
ADDITION_US = 0.005
LOOP_STEP_US = 5.0
"""Approximate time of one loop step."""
