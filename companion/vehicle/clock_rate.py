"""Measures how fast the autopilot's clock runs compared with ours; a simulator's may differ from 1.

The autopilot answers a TIMESYNC question after we send it and before its answer arrives. So two
answers bound the rate, whatever the delays of the link: the time between them on the autopilot's
clock, divided by the longest and the shortest time that can lie between them on ours. The rate
differs from 1 only if each of the last PAIRS pairs of answers proves it, all in the same direction.
If the computer was suspended, and its clock stood still, only one pair shows this. Rates outside
SLOWEST to QUICKEST are ignored: such a clock stands still or counts in other units.

Source: https://mavlink.io/en/services/timesync.html
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

PAIRS = 3
NEARLY = 0.03
"""A rate that differs from 1 by less is taken as 1; setpoints are off by no more than this then."""
SLOWEST, QUICKEST = 0.02, 50.0
"""Limits of simulators' rates."""


class ClockAnswer(NamedTuple):
    """When a question was sent and answered, by our clock; and what the other clock showed."""

    asked_s: float
    heard_s: float
    boot_s: float

    @property
    def round_trip_s(self) -> float:
        """Time from the question to its answer."""
        return self.heard_s - self.asked_s


class ClockRate:
    """The rate of a clock, from its answers.

    Attributes:
        has_differed: whether a rate other than 1 was ever found.

    >>> rate = ClockRate()
    >>> for i in range(4):
    ...     has_news = rate.take(ClockAnswer(100.0 + i, 100.1 + i, 7.0 + 4 * i))
    >>> rate.take_news()
    4.0
    >>> rate.take_news()
    """

    def __init__(self) -> None:
        self.has_differed = False
        self._answers: list[ClockAnswer] = []
        self._news: float | None = None

    def take(self, answer: ClockAnswer) -> bool:
        """Takes an answer; a clock that steps back has started anew, so earlier answers are
        dropped.

        Returns:
            whether it shows another rate than 1: there are news.
        """
        if self._answers and answer.boot_s < self._answers[-1].boot_s:
            self._answers.clear()
        self._answers = [*self._answers[-PAIRS:], answer]
        if len(self._answers) <= PAIRS:
            return False
        bounds = [_bounds(*pair) for pair in pairwise(self._answers)]
        is_quick = all(1.0 + NEARLY < least for least, _ in bounds)
        is_slow = all(most < 1.0 - NEARLY for _, most in bounds)
        rate = _between(self._answers[0], self._answers[-1])
        if not (is_quick or is_slow) or not SLOWEST <= rate <= QUICKEST:
            return False
        self._answers, self._news, self.has_differed = [answer], rate, True
        return True

    def take_news(self) -> float | None:
        """A rate that was found, once only; later answers are judged against it."""
        news, self._news = self._news, None
        return news


def _bounds(first: ClockAnswer, second: ClockAnswer) -> tuple[float, float]:
    """The least and the greatest possible rate between two answers."""
    passed_s = second.boot_s - first.boot_s
    shortest_s = second.asked_s - first.heard_s
    most = passed_s / shortest_s if shortest_s > 0.0 else math.inf
    return passed_s / (second.heard_s - first.asked_s), most


def _between(first: ClockAnswer, second: ClockAnswer) -> float:
    """The rate between two answers, if each was given halfway between question and arrival."""
    asked_s, heard_s = second.asked_s - first.asked_s, second.heard_s - first.heard_s
    return (second.boot_s - first.boot_s) / ((asked_s + heard_s) / 2)
