"""The autopilot's estimate of a companion's clock, from the answers to its TIMESYNC requests.

As in PX4, each link has its own estimate of how far the autopilot's clock is ahead; PX4 logs it as
`timesync_status`. A request with a round trip of 10 ms or more is left out as too inaccurate. A
second-order filter (offset and drift) smooths the others; its gains fall from 0.05 to 0.003 over
500 answers. After that, six answers in a row that are 100 ms off mean another clock, and the filter
starts again.

Source: PX4 v1.16, by the documentation of timesync_status and by observation.
"""

from __future__ import annotations

import math

ROUND_TRIP_MAX_US = 10_000
DEVIATION_MAX_US = 100_000
DEVIATIONS_MAX = 5
CONVERGED = 500
"""Number of answers until the filter has converged, 50 s."""
FIRST_GAIN, LAST_GAIN = 0.05, 0.003


class TimeOffset:
    """The estimate on one link.

    Attributes:
        estimated_us: by how much the autopilot's clock is ahead; 0 before the first answer.
        observed_us: the same by the newest answer alone.
        round_trip_us: the round trip of the newest answer.
        taken: number of answers in the estimate.
    """

    def __init__(self) -> None:
        self.observed_us = self.round_trip_us = 0.0
        self._begin()

    def _begin(self) -> None:
        self.estimated_us = self._drift_us = 0.0
        self.taken = self._deviations = 0

    @property
    def is_converged(self) -> bool:
        """Whether time stamps of the other clock can be trusted."""
        return self.taken >= CONVERGED

    def take(self, now_us: int, remote_ns: int, asked_ns: int) -> None:
        """Takes an answer.

        Args:
            now_us: our time.
            remote_ns: time of the other clock in the answer.
            asked_ns: our time in the request.
        """
        self.round_trip_us = now_us - asked_ns / 1000
        self.observed_us = (asked_ns / 1000 + now_us) / 2 - remote_ns / 1000
        if not 0 <= self.round_trip_us < ROUND_TRIP_MAX_US:
            return
        if self.is_converged and abs(self.observed_us - self.estimated_us) > DEVIATION_MAX_US:
            self._deviations += 1
            if self._deviations > DEVIATIONS_MAX:
                self._begin()
            return
        self._deviations = 0
        self._smooth(self.observed_us)
        self.taken += 1

    def _smooth(self, observed_us: float) -> None:
        if self.taken == 0:
            self.estimated_us = observed_us
            return
        before_us, gain = self.estimated_us, self._gain
        expected_us = before_us + self._drift_us
        self.estimated_us = gain * observed_us + (1 - gain) * expected_us
        self._drift_us = gain * (self.estimated_us - before_us) + (1 - gain) * self._drift_us

    @property
    def _gain(self) -> float:
        if self.is_converged:
            return LAST_GAIN
        share = 1.0 - math.exp(0.5 * (1.0 - 1.0 / (1.0 - self.taken / CONVERGED)))
        return share * LAST_GAIN + (1.0 - share) * FIRST_GAIN
