"""Local search: good tours of the generalised travelling salesman problem over many targets.

1. Cheapest insertion builds a first tour.
2. It is improved by 2-opt (reverse a part), or-opt (move a short part elsewhere) and exchange of a
   target for another one with the same marks, until no single change shortens it.
3. It is perturbed and improved again, a fixed number of times, so the same problem always has the
   same answer.

A 1-tree bound (`one_tree.py`) limits how far the tour is from the shortest.

Source: Or, Traveling salesman-type combinatorial problems, 1976; Martin, Otto and Felten,
Large-step Markov chains for the traveling salesman problem, 1991.
"""

from __future__ import annotations

import numpy as np

from companion.planning.builtin.costs import Costs, Marks
from companion.planning.builtin.one_tree import lower_bound_ms
from companion.planning.effort import ADDITION_US
from companion.slices import spent

PERTURBATIONS = 400
_MIN_PERTURBED = 8  # targets; smaller tours are not perturbed
_MAX_SPAN = 30  # targets; a perturbation of a longer part is hardly ever repaired
_MAX_STARTS = 10  # targets of the rarest mark from which tours are built
_MAX_SHIFTED = 3  # targets; longest part that or-opt moves

_CHANGE_US = 200
_CHANGES_ADDITIONS = 15
_TARGET_US = 15


class LocalSearch:
    """A good tour over some targets; the interface is `Tours`.

    Attributes:
        cost_ms: cost of the known tour.
        bound_ms: a lower bound for all tours; known after `improve`, 0 before.

    Args:
        between: cost of the shortest path with at least one edge from target to target, (T, T).
        marks: marks of the targets, (T, M).

    >>> between = np.array([[9, 1, 4], [5, 9, 2], [3, 6, 9]])
    >>> LocalSearch(between, np.eye(3, dtype=np.bool_)).cost_ms
    6
    """

    is_exact = False

    def __init__(self, between: Costs, marks: Marks) -> None:
        self._between = between
        self._marks = marks
        starts = np.flatnonzero(marks[:, marks.sum(axis=0).argmin()])[:_MAX_STARTS]
        tours = (
            _improved(_cheapest_insertion(int(target), between, marks), between, marks)
            for target in starts
        )
        self._order = min(tours, key=lambda order: _cost_ms(order, between))
        self.cost_ms = _cost_ms(self._order, between)
        self.bound_ms = 0

    def improve(self) -> None:
        """Looks for a shorter tour, and computes a lower bound."""
        self._order = _perturbed(self._order, self._between, self._marks)
        self.cost_ms = _cost_ms(self._order, self._between)
        self.bound_ms = lower_bound_ms(self._between, self._marks, self.cost_ms)

    def costs_through(self, to_targets: Costs, from_targets: Costs) -> Costs:
        """Cost of the tour with a detour to each of some nodes, (V,).

        Args:
            to_targets: cost from each node to each target, (T, V).
            from_targets: cost from each target to each node, (T, V).
        """
        costs: Costs = self.cost_ms + self._detours(to_targets, from_targets).min(axis=0)
        if len(self._order) == 1:  # at the only target the path there and back is empty
            costs = np.where(costs == 0, self.cost_ms, costs)
        return costs

    def cycle(self) -> list[int]:
        """The targets of the tour, beginning with any of them."""
        return self._order

    def order_after(self, to_targets: Costs, from_targets: Costs) -> list[int]:
        """The targets of the tour through a node, in the order in which they follow it."""
        place = int(self._detours(to_targets[:, None], from_targets[:, None])[:, 0].argmin()) + 1
        return self._order[place:] + self._order[:place]

    def _detours(self, to_targets: Costs, from_targets: Costs) -> Costs:
        """What a detour to a node after each target of the tour adds to its cost, (targets, V)."""
        following = np.roll(self._order, -1)
        legs = self._between[self._order, following]
        detours: Costs = from_targets[self._order] + to_targets[following] - legs[:, None]
        return detours


def _perturbed(order: list[int], between: Costs, marks: Marks) -> list[int]:
    """Iterated local search: the best tour after many perturbations, each followed by improvement.

    A perturbation is a double bridge: two neighbouring parts of the tour are swapped.
    """
    chance = np.random.default_rng(0)
    best, best_ms = order, _cost_ms(order, between)
    for _ in range(PERTURBATIONS if len(order) >= _MIN_PERTURBED else 0):
        cuts = 1 + np.sort(chance.choice(len(best) - 1, 3, replace=False))
        if cuts[2] - cuts[0] > _MAX_SPAN:
            continue
        a, b, c = map(int, cuts)
        tried = _improved(best[:a] + best[b:c] + best[a:b] + best[c:], between, marks)
        tried_ms = _cost_ms(tried, between)
        if tried_ms <= best_ms:
            best, best_ms = tried, tried_ms
    return best


def _cost_ms(order: list[int], between: Costs) -> int:
    """Cost of a tour."""
    return int(between[order, np.roll(order, -1)].sum())


def _cheapest_insertion(first: int, between: Costs, marks: Marks) -> list[int]:
    """A tour, built by adding the target that lengthens it least until all marks are met."""
    order = [first]
    met = marks[first].copy()
    while not met.all():
        spent(_CHANGE_US + ADDITION_US * len(order) * len(between))
        useful = np.flatnonzero((marks & ~met).any(axis=1))
        after = np.roll(order, -1)
        longer = between[order][:, useful] + between[useful][:, after].T
        longer -= between[order, after][:, None] if len(order) > 1 else 0
        place, which = np.unravel_index(int(longer.argmin()), longer.shape)
        order.insert(int(place) + 1, int(useful[which]))
        met |= marks[useful[which]]
    return order


def _improved(order: list[int], between: Costs, marks: Marks) -> list[int]:
    """A local optimum: a tour that no single change makes shorter."""
    order = _exchanged(order, between, marks)
    while len(order) > 3:
        spent(_CHANGE_US + _CHANGES_ADDITIONS * ADDITION_US * len(order) ** 2)
        along = between[order][:, order]
        changes = [_two_opt(along), *(_or_opt(along, n) for n in range(1, _MAX_SHIFTED + 1))]
        gain, places = min(changes, key=lambda change: change[0])
        if gain >= 0:
            break
        order = [order[i] for i in places]
        order = _exchanged(order, between, marks)
    return order


Change = tuple[int, list[int]]
"""What a change adds to the cost, and the new order, as positions in the old one."""


def _two_opt(along: Costs) -> Change:
    """The best reversal of a part, from i to j; costs may depend on the direction."""
    size = len(along)
    places = np.arange(size)
    following = np.roll(places, -1)
    forward = np.concatenate([[0], np.cumsum(along[places[:-1], places[1:]])])
    backward = np.concatenate([[0], np.cumsum(along[places[1:], places[:-1]])])
    turned = backward - forward
    before = np.roll(places, 1)
    gains = (
        along[before]  # [i, j]: from before i to j
        + along[:, following]
        - along[before, places][:, None]
        - along[places, following]
        + turned
        - turned[:, None]
    )
    gains[np.tril_indices(size)] = 0
    gains[0, -1] = 0  # the whole tour, reversed
    i, j = map(int, np.unravel_index(int(gains.argmin()), gains.shape))
    return int(gains[i, j]), [*range(i), *range(j, i - 1, -1), *range(j + 1, size)]


def _or_opt(along: Costs, length: int) -> Change:
    """The best shift of a part of given length, from i on, to between p and the place after it."""
    size = len(along)
    if size < length + 3:
        return 0, []
    first = np.arange(size)
    last = (first + length - 1) % size
    before, after = (first - 1) % size, (last + 1) % size
    following = (first + 1) % size
    closed = along[before, after] - along[before, first] - along[last, after]
    opened = along[:, first].T + along[last][:, following] - along[first, following]
    gains = closed[:, None] + opened
    offset = (first[None, :] - first[:, None]) % size
    gains[(offset < length) | (offset == size - 1)] = 0
    i, p = map(int, np.unravel_index(int(gains.argmin()), gains.shape))
    if gains[i, p] >= 0:
        return 0, []
    part = [(i + n) % size for n in range(length)]
    rest = [(i + length + n) % size for n in range(size - length)]
    cut = rest.index(p) + 1
    return int(gains[i, p]), rest[:cut] + part + rest[cut:]


def _exchanged(order: list[int], between: Costs, marks: Marks) -> list[int]:
    """Drops unneeded targets, and replaces others by the best ones with the same marks."""
    order = list(order)
    if len(order) == len(marks):
        return order  # each target has a mark that no other has
    for place in range(len(order) - 1, -1, -1):
        spent(_TARGET_US + ADDITION_US * len(order) * marks.shape[1])
        others = order[:place] + order[place + 1 :]
        needed = marks[order[place]] & ~marks[others].any(axis=0)
        if not needed.any() and others:
            order = others
            continue
        fitting = np.flatnonzero(marks[:, needed].all(axis=1))
        if len(fitting) > 1 and others:
            before, after = order[place - 1], order[(place + 1) % len(order)]
            order[place] = int(
                fitting[(between[before, fitting] + between[fitting, after]).argmin()]
            )
    return order
