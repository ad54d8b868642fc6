"""Learns how much more energy flights take than a mission says, from what they have taken.

A Kalman filter with one state estimates the ratio of used to predicted energy, which drifts slowly.
Plans use its mean plus two deviations, at most 5 % more. If more is used than that allows for, the
filter trusts the measurement almost fully; all other measurements are weighed against what was
known.

There are two ratios: the energy that flying takes, by voltage and current, relative to what the
mission says; and what the gauge counts relative to that energy, which is more for an aged battery.
Without a current, the gauge measures both at once. Plans use the product of the two.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

LEAST, MOST = 0.8, 3.0
"""Plans never rely on less than the least. The most is for a vehicle that cannot fly as fast as its
mission says, so that everything takes three times as long; beyond that plans are useless."""
DRIFT_PER_S, AGEING_PER_S = 0.01**2 / 60, 0.01**2 / 3600
"""Growth of the variance per second: winds turn, and batteries age."""
LEAST_DEVIATION = 0.01
EXPECTED_DEVIATION = 0.05
"""Standard deviation of a mission's figures before any flight."""
MOST_MORE = 0.05
"""The most that plans use above the mean."""


@dataclass(frozen=True, slots=True)
class RatioEstimate:
    """A ratio, as far as it is known.

    >>> known = RatioEstimate(1.0, 0.025)
    >>> later = known.after(1.2, deviation=0.03, seconds=60.0)
    >>> round(later.mean, 2), later.deviation < 0.05
    (1.18, True)
    >>> round(known.after(0.9, deviation=0.03, seconds=60.0).mean, 2)
    0.96

    Attributes:
        mean: the expected ratio.
        deviation: its standard deviation.
    """

    mean: float
    deviation: float

    def after(
        self, measured: float, deviation: float, seconds: float, drift_per_s: float = DRIFT_PER_S
    ) -> RatioEstimate:
        """The ratio after one more measurement.

        Args:
            measured: the measured ratio.
            deviation: standard deviation of the measurement.
            seconds: duration of the measurement.
            drift_per_s: growth of the variance per second.
        """
        variance = self.deviation**2 + drift_per_s * seconds
        more = measured - self.mean
        if more > 2 * math.hypot(math.sqrt(variance), deviation):
            variance = max(variance, (more / 2) ** 2)  # it has changed, for the worse
        gain = variance / (variance + deviation**2)
        mean = min(MOST, max(LEAST, self.mean + gain * more))
        left = math.sqrt((1 - gain) * variance)
        return RatioEstimate(mean, max(LEAST_DEVIATION, left))


@dataclass(frozen=True, slots=True)
class KnownRatios:
    """The known ratios of energy in flights.

    Attributes:
        flying: energy that flights take, relative to what the mission says.
        gauge: what the gauge counts, relative to that energy.
    """

    flying: RatioEstimate = RatioEstimate(1.0, EXPECTED_DEVIATION)
    gauge: RatioEstimate = RatioEstimate(1.0, EXPECTED_DEVIATION)

    @property
    def mean(self) -> float:
        """What the gauge counts, relative to what the mission says."""
        return self.flying.mean * self.gauge.mean

    @property
    def to_plan_with(self) -> float:
        """The ratio to plan with: two deviations above the mean, within limits."""
        deviation = math.hypot(self.flying.deviation, self.gauge.deviation)
        return min(MOST, max(LEAST, self.mean + min(2 * deviation, MOST_MORE)))
