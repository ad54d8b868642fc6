"""The effort of a search: limits that are counted, not timed.

So equal problems have equal answers on every machine.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Effort:
    """Limits of a search.

    Attributes:
        product_edges: edges of the product; with more of them the search is given up.
        dijkstra_steps: of all shortest-path searches, one search for each target: a step for each
            edge of the product, and 30 for each node (`product.dijkstra_steps`). Of too many
            targets the nearest are looked at.
        held_karp_additions: additions in the tables of exact tours; beyond them local search
            takes their place.
        loop_steps: edges that the search for loops sees which are no cycles of the product; beyond
            them it is not proved that no loop is better.
        time_labels: ways that the search for plans with bounds in time looks at.
        proves_laps: whether there is time to prove that a lap on a battery is the shortest, or to
            say how far from that it may be.
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
"""Well under a second of work, which is done in slices (slices.py)."""

PRODUCT_EDGE_US = 0.5
DIJKSTRA_STEP_US = 0.005
ADDITION_US = 0.005
LOOP_STEP_US = 5.0
"""What each of these takes, about."""
