"""How much more energy flights take than a mission says, learnt from what they took.

A Kalman filter with one state, the ratio of used to predicted energy, which drifts a little. Plans
are made with its mean and two deviations more, 5 % at most. Where more was used than that allows
for, the filter believes it nearly at once; all else is weighed against what was known.

Two ratios are known. What flying takes, by voltage and current, of what the mission says; and what
the gauge counts down of what was taken so, which is more for a pack that has aged. Without a
current the gauge tells both at once. Plans are made with their product.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

LEAST, MOST = 0.8, 3.0
"""Less than the least is not relied on. The most is a vehicle that cannot fly as fast as its
mission says, so that all takes three times as long; beyond that plans are of no use."""
DRIFT_PER_S, AGEING_PER_S = 0.01**2 / 60, 0.01**2 / 3600
"""Variance that comes by a second: winds turn; and batteries age."""
LEAST_DEVIATION = 0.01
EXPECTED_DEVIATION = 0.05
"""Of a mission's figures, before anything was flown."""
MOST_MORE = 0.05
"""Plans are made with so much more than the mean at most."""


@dataclass(frozen=True, slots=True)
class RatioEstimate:
    """A ratio, as it is known.

    >>> known = RatioEstimate(1.0, 0.025)
    >>> later = known.after(1.2, deviation=0.03, seconds=60.0)
    >>> round(later.mean, 2), later.deviation < 0.05
    (1.18, True)
    >>> round(known.after(0.9, deviation=0.03, seconds=60.0).mean, 2)
    0.96

    Attributes:
        mean: of what it may be.
        deviation: standard, of the same.
    """

    mean: float
    deviation: float

    def after(
        self, measured: float, deviation: float, seconds: float, drift_per_s: float = DRIFT_PER_S
    ) -> RatioEstimate:
        """What is known after one measurement more.

        Args:
            measured: the ratio.
            deviation: standard, of the measurement.
            seconds: for how long it was measured.
            drift_per_s: variance that has come by a second.
        """
        variance = self.deviation**2 + drift_per_s * seconds
        more = measured - self.mean
        if more > 2 * math.hypot(math.sqrt(variance), deviation):
            variance = max(variance, (more / 2) ** 2)  # it has changed, and for the worse
        gain = variance / (variance + deviation**2)
        mean = min(MOST, max(LEAST, self.mean + gain * more))
        left = math.sqrt((1 - gain) * variance)
        return RatioEstimate(mean, max(LEAST_DEVIATION, left))


@dataclass(frozen=True, slots=True)
class KnownRatios:
    """What is known of the energy of flights.

    Attributes:
        flying: what they take of what the mission says.
        gauge: what the gauge counts of that.
    """

    flying: RatioEstimate = RatioEstimate(1.0, EXPECTED_DEVIATION)
    gauge: RatioEstimate = RatioEstimate(1.0, EXPECTED_DEVIATION)

    @property
    def mean(self) -> float:
        """What the gauge counts of what the mission says."""
        return self.flying.mean * self.gauge.mean

    @property
    def to_plan_with(self) -> float:
        """The same, as much as it may be: two deviations more, within limits."""
        deviation = math.hypot(self.flying.deviation, self.gauge.deviation)
        return min(MOST, max(LEAST, self.mean + min(2 * deviation, MOST_MORE)))
