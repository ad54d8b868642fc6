"""Where a loop on a battery is entered in flight, so that no part of it waits for ever.

Each new plan begins its loop somewhere. Were that always where the loop is reached first, a vehicle
that runs short again and again would fly between the docks and what lies near them. So of all
places of the loop the one is taken after which the oldest mark is the youngest, as for plans
without a battery (`builtin/fair_entry.py`): each mark's age is the time since it was met last, at
the moment when the plan meets it first, and the largest of these ages is the least. Of equal ones
the shortest way is taken, and before the first completed skill that alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate

import numpy as np

from companion.ltl.bitsets import indices
from companion.planning.builtin.costs import UNREACHABLE_MS, Costs
from companion.planning.builtin.product import Product
from companion.planning.energy.approach import LoopApproach
from companion.slices import spent

_NODE_US = 5


@dataclass(frozen=True, slots=True)
class FairEntry:
    """A way into a loop.

    Attributes:
        place: of the edge of the loop with which it begins.
        rank: the worst age of a mark, and the time of the way; less is better.
    """

    place: int
    way: LoopApproach
    rank: tuple[int, int]


def fairest(
    product: Product,
    costs_ms: Sequence[int],
    ends: Sequence[int],
    ways: Iterable[tuple[int, LoopApproach, Sequence[int]]],
) -> FairEntry | None:
    """The entry with which the worst age of a mark is the least; None if there is no way.

    Ways that take a lap longer than the quickest one are not looked at.

    Args:
        product: knows since when each mark waits; if none does, the quickest way is taken.
        costs_ms: of the edges of the loop.
        ends: the nodes to which they lead.
        ways: to places of the loop, the quickest one first, with the costs of their steps.
    """
    entries = _entries(product, costs_ms, ends, ways)
    if not product.waiting_since_ms:
        return next(entries, None)
    return min(entries, key=lambda entry: entry.rank, default=None)  # the first of equals


def _entries(
    product: Product,
    costs_ms: Sequence[int],
    ends: Sequence[int],
    ways: Iterable[tuple[int, LoopApproach, Sequence[int]]],
) -> Iterator[FairEntry]:
    lap_ms, first_ms = sum(costs_ms), None
    for place, way, steps_ms in ways:
        if not product.waiting_since_ms:
            yield FairEntry(place, way, (0, way.time_ms))
            continue
        first_ms = way.time_ms if first_ms is None else first_ms
        if way.time_ms > first_ms + lap_ms:
            return
        spent(_NODE_US * (len(ends) + len(steps_ms)))
        passed = [*(step.node for step in way.steps[1:]), way.end][: len(way.steps)]
        nodes = [*passed, *ends[place:], *ends[:place]]
        times_ms = accumulate([*steps_ms, *costs_ms[place:], *costs_ms[:place]])
        met_ms = _met(product, nodes, list(times_ms))
        worst_ms = int((met_ms - product.waiting_since_ms).max(initial=0))
        yield FairEntry(place, way, (worst_ms, way.time_ms))


def _met(product: Product, nodes: Sequence[int], times_ms: Sequence[int]) -> Costs:
    """When each mark is met first."""
    met = np.full(product.all_marks.bit_length(), UNREACHABLE_MS)
    for node, time_ms in zip(nodes[::-1], times_ms[::-1], strict=True):
        met[list(indices(product.marks[node]))] = time_ms
    return met
