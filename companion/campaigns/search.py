"""Searches for rows that fail, guided by the least margin of rows that do not.

1. The search proceeds in generations. Each follows from the campaign's seed and the earlier
   generations, never from the number of processes.
2. The first generation fills the unit cube evenly (Sobol, 1967).
3. From the worst row, CMA-ES (Hansen and Ostermeier, 2001) proceeds towards a smaller margin. It
   only ranks the rows of a generation: by score, rounded to steps; among equals, rarely seen kinds
   of flights first. So where scores are flat, novelty guides the search.
4. The aim is different failures. After a failure, its neighbourhood is excluded and a new search
   begins at the worst row elsewhere. The same happens when a search makes no progress.
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
    from companion.flights.simulated_world import Factor

GENERATION = 16
SIGMA = 0.2
"""Initial step size of a search, as a share of the cube's edge."""
NEAR = 0.25
"""Two rows are alike if the root mean square of their coordinate differences is below this."""
PATIENCE = 4
"""Number of generations without a lower score after which a search begins elsewhere."""
STEP = 0.05
"""Scores within one such step are equal."""
DIGITS = 6
RowFlyer = Callable[[Sequence[Row]], tuple[FlownRow, ...]]
"""Flies rows and returns them in the same order."""
Point = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Tried:
    """A row that the search has flown, with its point."""

    point: Point
    flown: FlownRow


def first_points(dimensions: int, seed: int, budget: int) -> list[Point]:
    """The points of the first generation: a power of two, about a quarter of the budget."""
    least, most = (min(n, budget) for n in (GENERATION, 128))
    count = max(least, min(most, budget // 4))
    power = int(math.log2(count))
    sequence = qmc.Sobol(dimensions, rng=np.random.default_rng(seed))
    return [rounded(point) for point in sequence.random_base2(power)]


def rounded(point: Point) -> Point:
    """A point within the cube, rounded to the stored digits."""
    return np.clip(np.round(point, DIGITS), 0.0, 1.0 - 10.0**-DIGITS)


class FailureSearch:
    """One search.

    Args:
        factors: each is a dimension of the unit cube.
        seed: the seed of the campaign.
        budget: number of rows.

    Attributes:
        tried: all rows so far, in order.
    """

    def __init__(self, factors: Sequence[Factor], seed: int, budget: int) -> None:
        self._factors, self._seed, self._budget = factors, seed, budget
        self._dimensions = max(2, len(factors))  # CMA-ES needs two; the second may be unused
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
        """Searches from one point until it finds a failure or makes no progress."""
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
        """The rank of each row of a generation; the lower, the nearer to a new failure."""
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
        """The start of the next search: the worst row that is near no failure and no earlier start.

        If there is none, it is the row farthest from all of them.
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
    """The distance of two points: the root mean square of their coordinate differences."""
    return float(np.sqrt(np.mean((one - other) ** 2)))


def is_near(point: Point, others: Sequence[Point]) -> bool:
    """Whether a point is near one of the others."""
    return any(distance(point, other) < NEAR for other in others)


def first_of_each_kind(flown: Sequence[FlownRow]) -> tuple[FlownRow, ...]:
    """The first failure of each kind and place; others count as the same."""
    found: dict[tuple[str, str], FlownRow] = {}
    for each in flown:
        if each.is_failure:
            found.setdefault((each.kind, each.place), each)
    return tuple(found.values())
