"""How fast the autopilot's clock runs beside ours; another rate than 1 is a simulator's.

An answer to TIMESYNC was given after our question was sent and before it arrived. So two answers
bound the rate, whatever the link does: what lies between them on the autopilot's clock, over the
most and the least that can lie between them on ours. It is another rate where the last PAIRS of
answers leave no doubt of it, all on one side. A computer that was suspended, whose clock stood
still, shows one such pair alone. A clock that stands, or counts in other units, is none to go by.

Source: https://mavlink.io/en/services/timesync.html
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

PAIRS = 3
NEARLY = 0.03
"""A rate that is off by less is none: setpoints are, by as little."""
SLOWEST, QUICKEST = 0.02, 50.0
"""Of simulators."""


class ClockAnswer(NamedTuple):
    """When a question was asked and answered, by our clock, and what the other clock showed."""

    asked_s: float
    heard_s: float
    boot_s: float

    @property
    def round_trip_s(self) -> float:
        """How long question and answer were under way."""
        return self.heard_s - self.asked_s


class ClockRate:
    """The rate of a clock, from what it is asked.

    Attributes:
        has_differed: whether it was another one than 1, once.

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
        """Takes an answer; a clock that steps back is another one, that has begun anew.

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
        """A rate that was found; given once. Answers that follow are by a clock that has it."""
        news, self._news = self._news, None
        return news


def _bounds(first: ClockAnswer, second: ClockAnswer) -> tuple[float, float]:
    """The least and the greatest rate between two answers."""
    passed_s = second.boot_s - first.boot_s
    shortest_s = second.asked_s - first.heard_s
    most = passed_s / shortest_s if shortest_s > 0.0 else math.inf
    return passed_s / (second.heard_s - first.asked_s), most


def _between(first: ClockAnswer, second: ClockAnswer) -> float:
    """The rate between two answers if each was given in the middle of its way."""
    asked_s, heard_s = second.asked_s - first.asked_s, second.heard_s - first.heard_s
    return (second.boot_s - first.boot_s) / ((asked_s + heard_s) / 2)
