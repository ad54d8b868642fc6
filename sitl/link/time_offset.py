"""What the autopilot reckons of a companion's clock, from the answers to its TIMESYNC questions.

As PX4 does on each of its links, and writes into its log (topic `timesync_status`): how far its own
clock is ahead of the other one. A question that took 10 ms or more there and back says too little
and is left out. What is left is smoothed by a filter of second order (offset and drift), whose
gains fall from 0.05 to 0.003 over 500 answers. After that, six answers in a row that are 100 ms off
are another clock, and it begins anew.

Source: PX4 v1.16, as documented for timesync_status and as it was seen to behave.
"""

from __future__ import annotations

import math

ROUND_TRIP_MAX_US = 10_000
DEVIATION_MAX_US = 100_000
DEVIATIONS_MAX = 5
CONVERGED = 500
"""Answers, 50 s of them."""
FIRST_GAIN, LAST_GAIN = 0.05, 0.003


class TimeOffset:
    """The estimate on one link.

    Attributes:
        estimated_us: by how much the autopilot's clock is ahead; 0 before the first answer.
        observed_us: the same by the newest answer alone.
        round_trip_us: of the newest answer.
        taken: how many answers the estimate is made of.
    """

    def __init__(self) -> None:
        self.observed_us = self.round_trip_us = 0.0
        self._begin()

    def _begin(self) -> None:
        self.estimated_us = self._drift_us = 0.0
        self.taken = self._deviations = 0

    @property
    def is_converged(self) -> bool:
        """Whether stamps of the other clock are trusted."""
        return self.taken >= CONVERGED

    def take(self, now_us: int, remote_ns: int, asked_ns: int) -> None:
        """Takes an answer.

        Args:
            now_us: our time.
            remote_ns: what the other clock showed.
            asked_ns: our time in the question.
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
