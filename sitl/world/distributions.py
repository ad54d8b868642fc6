"""The values that a key of a scenario may take in a campaign: ranges and distributions.

Each is given by its inverse distribution function, which maps a number between 0 and 1 to a value.
So a row of a campaign is a point of the unit cube, whether a random generator, a space-filling
sequence or a search has chosen it.

Numbers are rounded to six significant digits and flown as they are written, so a row and its
scenario file give the same flight.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import accumulate
from statistics import NormalDist

Value = bool | int | float | str
TAILS = 4.0
"""Where a normal distribution without bounds is cut off, in standard deviations."""


def rounded(number: float) -> float:
    """The number with six significant digits.

    >>> rounded(12.3456789), rounded(2.0)
    (12.3457, 2.0)
    """
    return float(f"{number:.6g}")


@dataclass(frozen=True, slots=True)
class Uniform:
    """A number from a range, uniformly distributed.

    >>> Uniform(-3.0, 3.0).value(0.75)
    1.5
    """

    low: float
    high: float

    def value(self, u: float) -> Value:
        """The value at a share of the range, from 0 to 1."""
        return rounded(self.low + u * (self.high - self.low))

    @property
    def extremes(self) -> tuple[Value, ...]:
        """The values that must all be valid for every other value to be valid."""
        return rounded(self.low), rounded(self.high)

    def __str__(self) -> str:
        return f"{self.low:g} to {self.high:g}"


@dataclass(frozen=True, slots=True)
class Normal:
    """A normally distributed number, cut off at both ends.

    >>> Normal(1.0, 0.5, 0.0, 2.0).value(0.5)
    1.0
    """

    mean: float
    deviation: float
    low: float
    high: float

    def value(self, u: float) -> Value:
        """The value of a quantile, from 0 to 1."""
        bell = NormalDist(self.mean, self.deviation)
        least, most = bell.cdf(self.low), bell.cdf(self.high)
        share = min(max(least + u * (most - least), 1e-12), 1 - 1e-12)
        return min(max(rounded(bell.inv_cdf(share)), rounded(self.low)), rounded(self.high))

    @property
    def extremes(self) -> tuple[Value, ...]:
        """The values that must all be valid for every other value to be valid."""
        return rounded(self.low), rounded(self.high)

    def __str__(self) -> str:
        return f"{self.mean:g} ± {self.deviation:g}, {self.low:g} to {self.high:g}"


@dataclass(frozen=True, slots=True)
class Choice:
    """One of several values, chosen by weight.

    >>> Choice(("ACCEPTED", "FAILED"), (3.0, 1.0)).value(0.8)
    'FAILED'
    """

    values: tuple[Value, ...]
    weights: tuple[float, ...]

    def value(self, u: float) -> Value:
        """The first value at which the sum of the weights reaches a share of the total."""
        total = sum(self.weights)
        reached = zip(self.values, accumulate(self.weights), strict=True)
        return next((v for v, weight in reached if u * total < weight), self.values[-1])

    @property
    def extremes(self) -> tuple[Value, ...]:
        """The values that must all be valid for every other value to be valid."""
        return self.values

    def __str__(self) -> str:
        total = sum(self.weights)
        return ", ".join(
            f"{value} ({weight / total:.0%})"
            for value, weight in zip(self.values, self.weights, strict=True)
        )


@dataclass(frozen=True, slots=True)
class Chance:
    """True, or an entry that is present, in a share of all rows.

    >>> Chance(0.3).value(0.2), Chance(0.3).value(0.4)
    (True, False)
    """

    share: float

    def value(self, u: float) -> Value:
        """True below the share."""
        return u < self.share

    @property
    def extremes(self) -> tuple[Value, ...]:
        """The values that must all be valid for every other value to be valid."""
        return True, False

    def __str__(self) -> str:
        return f"in {self.share:.0%} of all rows"


Distribution = Uniform | Normal | Choice | Chance
