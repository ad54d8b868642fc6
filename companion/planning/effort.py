"""How much may a search cost? Counted, not timed, so that equal problems have equal answers."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Effort:
    """Limits of a search.

    Attributes:
        edges: of the product; with more of them the search is given up. About 4 us each.
        ways: shortest ways times edges; of more hits the nearest are looked at. About 0.2 us each.
        additions: in the tables of exact rounds; beyond them rounds are improved instead. About
            5 ns each.
    """

    edges: int
    ways: int
    additions: int


ON_THE_GROUND = Effort(edges=2_000_000, ways=40_000_000, additions=60_000_000)
IN_FLIGHT = Effort(edges=80_000, ways=1_000_000, additions=15_000_000)
"""Well under a second, the time after which an autopilot misses its setpoints."""
