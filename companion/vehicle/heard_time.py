"""A clock that runs while the autopilot is heard.

Goals and commands have their time in it: what cannot be heard cannot be observed, and a command to
somebody who is not heard may take effect at any later time.
"""

from __future__ import annotations

import math

QUIET_S = 0.5
"""Silence after which nothing is heard; a PX4 sends more than a hundred messages a second."""
FOLLOWS_S = 5.0
"""From the end of an interruption to the failsafe by which a loss of our stream is told."""


class Interruption:
    """The end of the last time in which the autopilot was not heard, or nothing was done here.

    A hold by a failsafe that follows soon is no decision of a pilot: it is the loss of our stream.
    """

    def __init__(self) -> None:
        self._stepped_s = self._ended_s = -math.inf

    def step(self, now_s: float, is_quiet: bool) -> None:
        """Once a tick; whether nothing is heard now."""
        if is_quiet or now_s - self._stepped_s >= QUIET_S:
            self._ended_s = now_s
        self._stepped_s = now_s

    def forget(self) -> None:
        """What follows from now on does not follow from it."""
        self._ended_s = -math.inf

    @property
    def is_recent(self) -> bool:
        """Whether a failsafe may follow from it."""
        return self._stepped_s - self._ended_s <= FOLLOWS_S


class HeardTime:
    """The time in which something was heard.

    >>> time = HeardTime()
    >>> for now_s in (10.0, 10.25, 10.5, 10.75, 60.0):
    ...     time.step(now_s, is_heard=now_s < 10.5)
    >>> time.seconds, time.is_quiet
    (0.75, True)

    Attributes:
        seconds: of it, since the first step.
        is_quiet: nothing is heard now.
    """

    def __init__(self) -> None:
        self.seconds = 0.0
        self.is_quiet = True
        self._heard_s = -math.inf
        self._stepped_s: float | None = None

    def step(self, now_s: float, is_heard: bool) -> None:
        """Time has passed; whether something has arrived in it."""
        passed_s = now_s - (now_s if self._stepped_s is None else self._stepped_s)
        self._stepped_s = now_s
        if is_heard:
            self._heard_s = now_s
        self.is_quiet = now_s - self._heard_s > QUIET_S
        if not self.is_quiet:
            self.seconds += passed_s
