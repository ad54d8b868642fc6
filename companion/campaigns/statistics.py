"""Statistics of a campaign's rows: a rate, the effect of a factor, a comparison of versions.

Intervals are exact (Clopper and Pearson, 1934); they hold for random rows whose number was fixed
beforehand. Two versions on the same rows are compared by the rows that differ (McNemar, 1947), with
the exact test. A factor matters as much as its ranks correlate with those of the margin (Spearman,
1904).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from scipy.stats import binomtest, rankdata

CONFIDENCE = 0.95


@dataclass(frozen=True, slots=True)
class Rate:
    """A share of rows, and the 95 % confidence interval of the true one.

    >>> print(Rate.of(3, 150))
    2.0 % (0.4 to 5.7 %)
    """

    count: int
    total: int
    low: float
    high: float

    @classmethod
    def of(cls, count: int, total: int) -> Rate:
        """The rate of `count` among `total`."""
        if total == 0:
            return cls(0, 0, 0.0, 1.0)
        interval = binomtest(count, total).proportion_ci(CONFIDENCE, method="exact")
        return cls(count, total, float(interval.low), float(interval.high))

    @property
    def share(self) -> float:
        """The share itself."""
        return self.count / self.total if self.total else 0.0

    def __str__(self) -> str:
        return f"{100 * self.share:.1f} % ({100 * self.low:.1f} to {100 * self.high:.1f} %)"


@dataclass(frozen=True, slots=True)
class Comparison:
    """Two versions on the same rows.

    Attributes:
        rows: number of rows that both have.
        worse: rows that fail now and did not before.
        better: rows that failed before and do not now.
        p: probability of a difference at least as uneven if neither version is better.
    """

    rows: int
    worse: tuple[int, ...]
    better: tuple[int, ...]
    p: float

    @property
    def is_significant(self) -> bool:
        """Whether chance is an unlikely explanation."""
        return self.p < 1 - CONFIDENCE


def compare(before: Sequence[tuple[int, bool]], now: Sequence[tuple[int, bool]]) -> Comparison:
    """Compares the failures of two versions on the rows that both have.

    >>> compare([(0, False), (1, False)], [(0, True), (1, False)]).worse
    (0,)

    Args:
        before: index of each row, and whether it failed.
        now: likewise.
    """
    failed = dict(before)
    common = [(index, failed[index], is_failure) for index, is_failure in now if index in failed]
    worse = tuple(index for index, then, is_failure in common if is_failure and not then)
    better = tuple(index for index, then, is_failure in common if then and not is_failure)
    differing = len(worse) + len(better)
    p = float(binomtest(len(worse), differing).pvalue) if differing else 1.0
    return Comparison(len(common), worse, better, p)


def rank_correlation(xs: Sequence[float], ys: Sequence[float]) -> float:
    """Rank correlation of two series, -1 to 1; 0 if one of them does not vary.

    >>> rank_correlation([1.0, 2.0, 3.0], [10.0, 30.0, 20.0])
    0.5
    """
    if len(xs) < 3 or len(set(xs)) < 2 or len(set(ys)) < 2:
        return 0.0
    first, second = rankdata(xs), rankdata(ys)
    first, second = first - first.mean(), second - second.mean()
    return float(first @ second / math.sqrt(float(first @ first) * float(second @ second)))
