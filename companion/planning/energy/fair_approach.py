"""Chooses where a replan enters a loop on a battery, so that no part of it waits for ever.

If each new plan began its loop where it is reached first, a vehicle that runs short again and again
would only fly between the docks and what lies near them. So the loop is entered where the oldest
mark is youngest, as in plans without a battery (`builtin/fair_entry.py`): a mark's age is the time
since it was last met, at the moment when the plan meets it first, and the largest age is minimised.
Ties go to the shortest path. Before the first completed skill only the shortest path counts.
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
    """A path into a loop.

    Attributes:
        place: the position in the loop of the edge with which it is entered.
        rank: the largest age of a mark, and the time of the path; less is better.
    """

    place: int
    path: LoopApproach
    rank: tuple[int, int]


def fairest(
    product: Product,
    costs_ms: Sequence[int],
    ends: Sequence[int],
    paths: Iterable[tuple[int, LoopApproach, Sequence[int]]],
) -> FairEntry | None:
    """The entry for which the largest age of a mark is the least; None if there is no path.

    Paths that take a lap longer than the quickest one are ignored.

    Args:
        product: knows since when each mark waits; if none does, the quickest path is taken.
        costs_ms: costs of the loop's edges.
        ends: the nodes where these edges end.
        paths: paths to places of the loop, the quickest one first, with the costs of their steps.
    """
    entries = _entries(product, costs_ms, ends, paths)
    if not product.waiting_since_ms:
        return next(entries, None)
    return min(entries, key=lambda entry: entry.rank, default=None)  # the first of equal ones


def _entries(
    product: Product,
    costs_ms: Sequence[int],
    ends: Sequence[int],
    paths: Iterable[tuple[int, LoopApproach, Sequence[int]]],
) -> Iterator[FairEntry]:
    lap_ms, first_ms = sum(costs_ms), None
    for place, path, steps_ms in paths:
        if not product.waiting_since_ms:
            yield FairEntry(place, path, (0, path.time_ms))
            continue
        first_ms = path.time_ms if first_ms is None else first_ms
        if path.time_ms > first_ms + lap_ms:
            return
        spent(_NODE_US * (len(ends) + len(steps_ms)))
        passed = [*(step.node for step in path.steps[1:]), path.end][: len(path.steps)]
        nodes = [*passed, *ends[place:], *ends[:place]]
        times_ms = accumulate([*steps_ms, *costs_ms[place:], *costs_ms[:place]])
        met_ms = _met(product, nodes, list(times_ms))
        worst_ms = int((met_ms - product.waiting_since_ms).max(initial=0))
        yield FairEntry(place, path, (worst_ms, path.time_ms))


def _met(product: Product, nodes: Sequence[int], times_ms: Sequence[int]) -> Costs:
    """The time at which each mark is met first."""
    met = np.full(product.all_marks.bit_length(), UNREACHABLE_MS)
    for node, time_ms in zip(nodes[::-1], times_ms[::-1], strict=True):
        met[list(indices(product.marks[node]))] = time_ms
    return met
