"""What is a good way round when there are too many sites for the best one?

A first round is built by cheapest insertion and improved by moves that reverse a part of it, put
a short part elsewhere, or swap a hit for another one with the same marks. Then it is disturbed
and improved again, a fixed number of times: the same problem always has the same answer. How
far it can be from the best is told by a bound: the heaviest 1-tree over the marks, after Held
and Karp.

Source: Held and Karp, The traveling-salesman problem and minimum spanning trees, 1970; Or,
Traveling salesman-type combinatorial problems, 1976; Martin, Otto and Felten, Large-step Markov
chains for the traveling salesman problem, 1991.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import minimum_spanning_tree

from companion.planning.builtin.rounds import FAR, Costs

Marks = NDArray[np.bool_]

DISTURBANCES = 400
ASCENTS = 150
_STARTS = 10  # hits of the rarest mark from which a round is built
_PART = 3  # longest part that is put elsewhere


class Tour:
    """A good round over some hits; the interface is that of `Rounds`.

    Attributes:
        cost_ms: of the round that is known.
        bound_ms: no round is shorter; known after `improve`.

    Args:
        between: cost of the shortest way with at least one step from a hit to a hit, (H, H).
        marks: which marks each hit has, (H, K).
    """

    def __init__(self, between: Costs, marks: Marks) -> None:
        self._between = between
        self._marks = marks
        starts = np.flatnonzero(marks[:, marks.sum(axis=0).argmin()])[:_STARTS]
        rounds = (_improved(_inserted(int(hit), between, marks), between, marks) for hit in starts)
        self._order = min(rounds, key=lambda order: _cost_ms(order, between))
        self.cost_ms = _cost_ms(self._order, between)
        self.bound_ms = 0

    def improve(self) -> None:
        """Looks for a shorter round, and for how much shorter one could be."""
        self._order = _better(self._order, self._between, self._marks)
        self.cost_ms = _cost_ms(self._order, self._between)
        self.bound_ms = _lower_bound(self._between, self._marks, self.cost_ms)

    def through(self, to_hits: Costs, from_hits: Costs) -> Costs:
        """Cost of the round with a detour to each of some nodes, (V,).

        Args:
            to_hits: cost from each node to each hit, (H, V).
            from_hits: cost from each hit to each node, (H, V).
        """
        costs: Costs = self.cost_ms + self._detours(to_hits, from_hits).min(axis=0)
        if len(self._order) == 1:  # at the only hit the way there and back is empty
            costs = np.where(costs == 0, self.cost_ms, costs)
        return costs

    def cycle(self) -> list[int]:
        """The hits of the round, from any of them on."""
        return self._order

    def order(self, to_hits: Costs, from_hits: Costs) -> list[int]:
        """The hits of the round in the order in which they follow a node."""
        place = int(self._detours(to_hits[:, None], from_hits[:, None])[:, 0].argmin()) + 1
        return self._order[place:] + self._order[:place]

    def _detours(self, to_hits: Costs, from_hits: Costs) -> Costs:
        """What a node after each hit of the round adds to it, (hits, V)."""
        following = np.roll(self._order, -1)
        legs = self._between[self._order, following]
        detours: Costs = from_hits[self._order] + to_hits[following] - legs[:, None]
        return detours


def _better(order: list[int], between: Costs, marks: Marks) -> list[int]:
    """A round that is no longer than the given one, and usually shorter."""
    chance = np.random.default_rng(0)
    best, best_ms = order, _cost_ms(order, between)
    for _ in range(DISTURBANCES if len(order) >= 8 else 0):
        cuts = 1 + np.sort(chance.choice(len(best) - 1, 3, replace=False))
        if cuts[2] - cuts[0] > 30:  # a disturbance far apart is hardly ever mended
            continue
        a, b, c = map(int, cuts)
        tried = _improved(best[:a] + best[b:c] + best[a:b] + best[c:], between, marks)
        tried_ms = _cost_ms(tried, between)
        if tried_ms <= best_ms:
            best, best_ms = tried, tried_ms
    return best


def _cost_ms(order: list[int], between: Costs) -> int:
    """Cost of a round."""
    return int(between[order, np.roll(order, -1)].sum())


def _lower_bound(between: Costs, marks: Marks, upper_ms: int) -> int:
    """No round is shorter than this.

    A round passes a hit of every mark, so it is not shorter than a round over the marks with the
    least distance between their hits, in either direction.
    """
    groups = [np.flatnonzero(column) for column in marks.T]
    nearest = np.array([between[group].min(axis=0) for group in groups])
    least = np.array([nearest[:, group].min(axis=1) for group in groups])
    least[marks.T.astype(int) @ marks > 0] = 0  # a hit of both
    least = np.minimum(least, least.T)
    unit = int(np.gcd.reduce(between[between < FAR]))
    bound = _heaviest_one_tree(least.astype(float), upper_ms)
    return unit * int(np.ceil((bound - 1e-6) / unit))


def _heaviest_one_tree(costs: NDArray[np.float64], upper: float) -> float:
    """Subgradient ascent on the prices of nodes; the round with prices costs the same."""
    size = len(costs)
    if size < 3:
        return float(2 * costs[0, 1]) if size == 2 else 0.0
    prices = np.zeros(size)
    best, step = 0.0, 1.0
    for _ in range(ASCENTS):
        priced = costs + prices[:, None] + prices
        weight, degrees = _one_tree(priced)
        bound = weight - 2 * prices.sum()
        best = max(best, bound)
        slope = degrees - 2
        steepness = float(slope @ slope)
        if not steepness or best >= upper:
            break
        prices += step * max(upper - bound, 1.0) / steepness * slope
        step *= 0.97
    return best


def _one_tree(priced: NDArray[np.float64]) -> tuple[float, NDArray[np.int64]]:
    """A spanning tree of all nodes but the first, and the two cheapest edges of the first."""
    size = len(priced)
    shift = 1.0 - priced.min()  # scipy takes a weight of zero for no edge
    tree = minimum_spanning_tree(priced[1:, 1:] + shift).tocoo()
    ends = np.argsort(priced[0, 1:], kind="stable")[:2] + 1
    degrees = np.bincount(np.concatenate([tree.row, tree.col]) + 1, minlength=size)
    degrees[0] = 2
    degrees[ends] += 1
    weight = float(tree.data.sum()) - shift * (size - 2) + float(priced[0, ends].sum())
    return weight, degrees


def _inserted(first: int, between: Costs, marks: Marks) -> list[int]:
    """Cheapest insertion: the hit that lengthens the round least, until all marks are met."""
    order = [first]
    met = marks[first].copy()
    while not met.all():
        useful = np.flatnonzero((marks & ~met).any(axis=1))
        after = np.roll(order, -1)
        longer = between[order][:, useful] + between[useful][:, after].T
        longer -= between[order, after][:, None] if len(order) > 1 else 0
        place, which = np.unravel_index(int(longer.argmin()), longer.shape)
        order.insert(int(place) + 1, int(useful[which]))
        met |= marks[useful[which]]
    return order


def _improved(order: list[int], between: Costs, marks: Marks) -> list[int]:
    """A round that no single move shortens."""
    order = _with_better_hits(order, between, marks)
    while len(order) > 3:
        along = between[order][:, order]
        moves = [_best_reversal(along), *(_best_shift(along, n) for n in range(1, _PART + 1))]
        gain, make = min(moves, key=lambda move: move[0])
        if gain >= 0:
            break
        order = [order[i] for i in make]
        order = _with_better_hits(order, between, marks)
    return order


Move = tuple[int, list[int]]
"""What a move adds to the cost, and the new order as places of the old one."""


def _best_reversal(along: Costs) -> Move:
    """Reverses the part from i to j; costs may differ by direction."""
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
    gains[0, -1] = 0  # the whole round, turned
    i, j = map(int, np.unravel_index(int(gains.argmin()), gains.shape))
    return int(gains[i, j]), [*range(i), *range(j, i - 1, -1), *range(j + 1, size)]


def _best_shift(along: Costs, length: int) -> Move:
    """Puts the part of some length from i on between p and the place after it."""
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


def _with_better_hits(order: list[int], between: Costs, marks: Marks) -> list[int]:
    """Leaves out hits that are not needed, and takes the best hit for what each is needed for."""
    order = list(order)
    if len(order) == len(marks):
        return order  # each hit has a mark that no other has
    for place in range(len(order) - 1, -1, -1):
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
