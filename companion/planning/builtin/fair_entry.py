"""Chooses where a replan enters its loop, so that no part of the loop waits for ever.

If each new plan began its loop where it is reached first, an event that comes again and again could
keep the vehicle from the far end for good. So the loop is entered where the oldest mark is
youngest: a mark's age is the time since it was last met, at the moment when the plan meets it
first, and the largest age is minimised. Ties go to the shortest prefix.

A vehicle on its loop continues along it, because skipping a part would make that part older than a
lap.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import accumulate, pairwise

import numpy as np

from companion.ltl.bitsets import indices
from companion.planning.builtin.costs import UNREACHABLE_MS, Costs
from companion.planning.builtin.loop_entry import ProductPlan
from companion.planning.builtin.product import Product
from companion.planning.builtin.shortest_paths import Edge, ShortestPaths
from companion.slices import spent

_NODE_US = 5


def entered_fairly(
    product: Product, paths: ShortestPaths, plan: ProductPlan, loop: list[Edge]
) -> ProductPlan:
    """The plan, with its loop entered so that the largest age of a mark is the least.

    If the reverse direction costs the same, the loop is flown in the better direction.

    Args:
        product: knows since when each mark waits; if none does, the plan stays as it is.
        paths: the shortest paths in the product.
        plan: a plan whose loop has the same cost.
        loop: a cycle of the product.
    """
    if not product.waiting_since_ms or len(loop) == 1:
        return plan
    loops = [loop, back] if (back := _backwards(product, loop)) else [loop]
    _, chosen = min((_best_entry(product, paths, each) for each in loops), key=lambda e: e[0])
    prefix = paths.path_from_start(chosen[-1].end)
    return replace(
        plan,
        prefix=tuple(edge.action for edge in prefix),
        loop=tuple(edge.action for edge in chosen),
        prefix_ms=sum(edge.cost_ms for edge in prefix),
        has_best_prefix=False,
    )


def _best_entry(
    product: Product, paths: ShortestPaths, loop: list[Edge]
) -> tuple[tuple[int, int], list[Edge]]:
    """The loop from its best entry, preceded by the largest age and the cost of the prefix."""
    nodes = [edge.end for edge in loop]
    prefix_ms = paths.from_start[nodes]
    met_ms = prefix_ms[:, np.newaxis] + _met_after(product, loop)
    for place, node in enumerate(nodes):
        spent(_NODE_US * len(nodes))
        for passed, passed_ms in paths.passed(node):
            marks = list(indices(product.marks[passed]))
            met_ms[place, marks] = np.minimum(met_ms[place, marks], passed_ms)
    worst_ms = (met_ms - product.waiting_since_ms).max(axis=1)
    best = int(np.lexsort((prefix_ms, worst_ms))[0])
    return (int(worst_ms[best]), int(prefix_ms[best])), loop[best + 1 :] + loop[: best + 1]


def _backwards(product: Product, loop: list[Edge]) -> list[Edge] | None:
    """The loop in the other direction, if it exists and costs the same."""
    back: list[Edge] = []
    for here, before in pairwise(edge.end for edge in [*loop[::-1], loop[-1]]):
        leaving = slice(product.first[here], product.first[here + 1])
        (found,) = np.nonzero(product.ends[leaving] == before)
        if not len(found):
            return None
        number = int(product.first[here] + found[0])
        back.append(Edge(int(product.actions[number]), int(product.costs[number]), before))
    is_as_short = sum(e.cost_ms for e in back) == sum(e.cost_ms for e in loop)
    return back if is_as_short else None


def _met_after(product: Product, loop: list[Edge]) -> Costs:
    """How long after each node of a loop each mark is met next, (nodes, marks)."""
    reached_ms = np.fromiter(accumulate(edge.cost_ms for edge in loop), np.int64)
    lap_ms = int(reached_ms[-1])
    is_next_lap = np.tri(len(loop), dtype=np.int64)  # a node itself is reached a lap later
    until_ms = reached_ms - reached_ms[:, np.newaxis] + lap_ms * is_next_lap
    met = np.full((len(loop), product.all_marks.bit_length()), UNREACHABLE_MS)
    for place, edge in enumerate(loop):
        spent(_NODE_US)
        for mark in indices(product.marks[edge.end]):
            met[:, mark] = np.minimum(met[:, mark], until_ms[:, place])
    return met
