"""Lower bounds for completing a lap, ignoring its clocks; they guide the label setting."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from companion.planning.builtin.costs import UNREACHABLE_MS, Costs
from companion.planning.builtin.product import dijkstra_steps
from companion.planning.builtin.shortest_paths import cheapest_edges, whole
from companion.planning.effort import DIJKSTRA_STEP_US
from companion.planning.timed.component import TimedComponent
from companion.slices import spent

_SORTING_US = 0.2

Missing = Callable[[int, int], int]
"""By state and marks (bits) already met, the least cost of completing the lap."""


def completion(
    component: TimedComponent, anchor: int, barred: frozenset[int], most_edges: int
) -> Missing:
    """The least cost of the rest of a lap.

    Args:
        component: the component of the lap.
        anchor: the state where it ends.
        barred: states that it avoids.
        most_edges: edges between pairs of a state and marks already met; with more, it is only a
            bound.
    """
    numbers, edges = _edges(component, barred)
    sets = component.all + 1
    if len(edges) * sets > most_edges:
        return _by_farthest_mark(component, numbers, edges, anchor)
    starts, ends, costs, marks = np.array(edges, np.int64).reshape(-1, 4).T
    every = np.arange(sets)
    begins = (starts[:, np.newaxis] * sets + every).ravel()
    leads_to = (ends[:, np.newaxis] * sets + (every | marks[:, np.newaxis])).ravel()
    size = len(numbers) * sets
    backward = cheapest_edges(leads_to, begins, np.repeat(costs, sets), size)
    spent(_SORTING_US * len(begins) + DIJKSTRA_STEP_US * dijkstra_steps(size, len(begins)))
    found = whole(dijkstra(backward, indices=[numbers[anchor] * sets + component.all]))[0].tolist()
    return lambda state, met: int(found[numbers[state] * sets + met])


def completion_in_order(component: TimedComponent, anchor: int, barred: frozenset[int]) -> Missing:
    """The least cost of the rest of a lap with marks in order. Args: as in `completion`."""
    numbers, edges = _edges(component, barred)
    starts, ends, costs, marks = np.array(edges, np.int64).reshape(-1, 4).T
    forward, backward = _both_directions(starts, ends, costs, len(numbers))
    spent(DIJKSTRA_STEP_US * dijkstra_steps(len(numbers), len(edges)) * len(component.targets_of))
    rest = whole(dijkstra(backward, indices=[numbers[anchor]]))[0]
    by_count = [rest.tolist()]
    for mark in range(len(component.targets_of))[::-1]:
        rest = _through(forward, _last(starts, ends, costs, marks >> mark & 1, rest))
        by_count.append(rest.tolist())
    by_count.reverse()
    return lambda state, met: int(by_count[met.bit_count()][numbers[state]])


_Edges = list[tuple[int, int, int, int]]


def _edges(component: TimedComponent, barred: frozenset[int]) -> tuple[dict[int, int], _Edges]:
    """The numbers of states, and the steps between them: begin, end, cost, marks."""
    numbers = {state: i for i, state in enumerate(s for s in component.states if s not in barred)}
    edges = [
        (numbers[state], numbers[step.end], step.cost_ms, marks)
        for state in numbers
        for step, marks in component.steps(state)
        if step.end in numbers
    ]
    return numbers, edges


def _both_directions(
    starts: Costs, ends: Costs, costs: Costs, size: int
) -> tuple[csr_array, csr_array]:
    return cheapest_edges(starts, ends, costs, size), cheapest_edges(ends, starts, costs, size)


def _last(starts: Costs, ends: Costs, costs: Costs, meets: Costs, after: Costs) -> Costs:
    """By state, the least cost of a step that meets a mark, including what comes after it."""
    steps = meets.astype(bool)
    last = np.full(len(after), UNREACHABLE_MS)
    np.minimum.at(last, starts[steps], costs[steps] + after[ends[steps]])
    return last


def _by_farthest_mark(
    component: TimedComponent, numbers: dict[int, int], edges: _Edges, anchor: int
) -> Missing:
    """A lower bound: the path to the mark that is farthest away, and from there to the anchor."""
    starts, ends, costs, marks = np.array(edges, np.int64).reshape(-1, 4).T
    forward, backward = _both_directions(starts, ends, costs, len(numbers))
    count = len(component.targets_of)
    spent(2 * DIJKSTRA_STEP_US * dijkstra_steps(len(numbers), len(edges)) * (1 + count))
    to_anchor = whole(dijkstra(backward, indices=[numbers[anchor]]))[0]
    by_mark = [
        _through(forward, _last(starts, ends, costs, marks >> mark & 1, to_anchor)).tolist()
        for mark in range(count)
    ]
    alone = to_anchor.tolist()

    def missing(state: int, met: int) -> int:
        number = numbers[state]
        left = (own[number] for mark, own in enumerate(by_mark) if not met >> mark & 1)
        return int(max(alone[number], max(left, default=0)))

    return missing


def _through(forward: csr_array, last: Costs) -> Costs:
    """By state, the least cost of a path to another state plus the value there."""
    size = forward.shape[0]
    begins, ends = forward.nonzero()
    at = np.flatnonzero(last < UNREACHABLE_MS)
    rows = np.concatenate((ends, np.full(len(at), size)))
    columns = np.concatenate((begins, at))
    costs = np.concatenate((forward.data, last[at].astype(float)))
    graph = csr_array((costs, (rows, columns)), shape=(size + 1, size + 1))
    found: Costs = whole(dijkstra(graph, indices=[size]))[0, :size]
    return found
