"""Searches for rows that fail, by the least margin of those that do not.

Batch-synchronous: what a generation consists of follows from the seed of the campaign and the rows
of the generations before, and never from how many processes fly it. A generation of points that
fill the unit cube evenly (Sobol, 1967) comes first. Then CMA-ES (Hansen and Ostermeier, 2001) goes
from the worst row on towards less margin. It only ranks the rows of a generation: by their score in
steps, among equals by how seldom a flight of that kind was seen. So where verdicts are flat, what
is new leads.

Different failures are wanted. When a generation has found one, what is near it is forbidden, and
another search begins at the worst row elsewhere; so does one that gets nowhere.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from cmaes import CMA
from scipy.stats import qmc

from companion.campaigns.outcomes import FlownRow
from companion.campaigns.rows import Row, row_at

if TYPE_CHECKING:
    from companion.api.simulating import Factor

GENERATION = 16
SIGMA = 0.2
"""Of a search at its begin, as a share of the cube."""
NEAR = 0.25
"""Root mean square of the distance in each factor, within which two rows are alike."""
PATIENCE = 4
"""Generations without a lower score after which a search begins elsewhere."""
STEP = 0.05
"""Scores in one step are equal."""
DIGITS = 6
RowFlyer = Callable[[Sequence[Row]], tuple[FlownRow, ...]]
"""Flies rows, and returns them in their order."""
Point = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Tried:
    """A row that the search has flown, and where it lies."""

    point: Point
    flown: FlownRow


def first_points(dimensions: int, seed: int, budget: int) -> list[Point]:
    """The points of the first generation: a power of two, a quarter of the budget or so."""
    least, most = (min(n, budget) for n in (GENERATION, 128))
    count = max(least, min(most, budget // 4))
    power = int(math.log2(count))
    sequence = qmc.Sobol(dimensions, rng=np.random.default_rng(seed))
    return [rounded(point) for point in sequence.random_base2(power)]


def rounded(point: Point) -> Point:
    """A point within the cube, with the digits that it is kept with."""
    return np.clip(np.round(point, DIGITS), 0.0, 1.0 - 10.0**-DIGITS)


class FailureSearch:
    """One search.

    Args:
        factors: what varies; the unit cube has an edge for each.
        seed: of the campaign.
        budget: of rows.

    Attributes:
        tried: all rows so far, in order.
    """

    def __init__(self, factors: Sequence[Factor], seed: int, budget: int) -> None:
        self._factors, self._seed, self._budget = factors, seed, budget
        self._dimensions = max(2, len(factors))  # CMA-ES needs two; the second may mean nothing
        self._generation = 0
        self._seen: Counter[str] = Counter()
        self._forbidden: list[Point] = []
        self._begun: list[Point] = []
        self.tried: list[Tried] = []

    def run(self, fly: RowFlyer) -> tuple[FlownRow, ...]:
        """Flies rows until the budget is used up; returns the first failure of each kind."""
        self._try(first_points(self._dimensions, self._seed, self._budget), fly)
        while self._left > 0 and (start := self._start()) is not None:
            self._descend(start, fly)
        return first_of_each_kind([each.flown for each in self.tried])

    @property
    def _left(self) -> int:
        return self._budget - len(self.tried)

    def _descend(self, start: Point, fly: RowFlyer) -> None:
        """A search from one point, until it has failed, or gets nowhere."""
        self._begun.append(start)
        bounds = np.array([[0.0, 1.0]] * self._dimensions)
        seed = (self._seed + len(self._begun)) % 2**32
        cma = CMA(start, SIGMA, bounds=bounds, population_size=GENERATION, seed=seed)
        best, waited = math.inf, 0
        while self._left > 0 and waited < PATIENCE and not cma.should_stop():
            asked = [cma.ask() for _ in range(GENERATION)]
            new = self._try([rounded(point) for point in asked], fly)
            if any(each.flown.is_failure and not self._is_forbidden(each.point) for each in new):
                self._forbidden += [each.point for each in new if each.flown.is_failure]
                return
            if len(new) < GENERATION:
                return
            cma.tell(list(zip(asked, self._ranks(new), strict=True)))
            score = min(each.flown.score for each in new)
            best, waited = (score, 0) if score < best - STEP else (best, waited + 1)

    def _try(self, points: Sequence[Point], fly: RowFlyer) -> list[Tried]:
        self._generation += 1
        first, used = len(self.tried), points[: self._left]
        rows = [
            row_at(self._factors, self._seed, first + i, point[: len(self._factors)].tolist())
            for i, point in enumerate(used)
        ]
        numbered = [Row(r.index, r.seed, r.values, self._generation) for r in rows]
        new = [Tried(point, flown) for point, flown in zip(used, fly(numbered), strict=True)]
        self.tried += new
        if self._generation == 1:
            self._forbidden += [each.point for each in new if each.flown.is_failure]
        return new

    def _ranks(self, new: Sequence[Tried]) -> list[float]:
        """The rank of each row of a generation; the lower, the nearer to another failure."""
        keys = [
            (
                self._is_forbidden(each.point),
                math.floor(each.flown.score / STEP),
                self._seen[each.flown.signature],
                each.flown.score,
            )
            for each in new
        ]
        self._seen.update(each.flown.signature for each in new)
        order = sorted(range(len(new)), key=lambda i: keys[i])
        ranks = [0.0] * len(new)
        for rank, i in enumerate(order):
            ranks[i] = float(rank)
        return ranks

    def _start(self) -> Point | None:
        """Where the next search begins: at the worst row that is like no failure and no start.

        If there is none, it is the row that is furthest from all of them.
        """
        known = [*self._forbidden, *self._begun]
        valid = [each for each in self.tried if each.flown.outcome.is_valid]
        if not valid:
            return None
        new = [each for each in valid if not is_near(each.point, known)]
        if new:
            return min(new, key=lambda each: each.flown.score).point
        return max(valid, key=lambda each: min(distance(each.point, to) for to in known)).point

    def _is_forbidden(self, point: Point) -> bool:
        return is_near(point, self._forbidden)


def distance(one: Point, other: Point) -> float:
    """How far two points are apart: the root mean square of their coordinates."""
    return float(np.sqrt(np.mean((one - other) ** 2)))


def is_near(point: Point, others: Sequence[Point]) -> bool:
    """Whether a point is like one of some others."""
    return any(distance(point, other) < NEAR for other in others)


def first_of_each_kind(flown: Sequence[FlownRow]) -> tuple[FlownRow, ...]:
    """The first failure of each kind, by place; flights that fail alike are one failure."""
    found: dict[tuple[str, str], FlownRow] = {}
    for each in flown:
        if each.is_failure:
            found.setdefault((each.kind, each.place), each)
    return tuple(found.values())
