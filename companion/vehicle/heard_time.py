"""A clock that runs only while the autopilot is heard.

Goals and commands are timed by it. Without hearing the autopilot nothing can be observed, and a
command sent meanwhile might take effect at any later time.
"""

from __future__ import annotations

import math

QUIET_S = 0.5
"""After this silence the autopilot counts as not heard; a PX4 sends over a hundred messages a
second."""
FOLLOWS_S = 5.0
"""A failsafe that reports the loss of our stream begins within this time of an interruption's
end."""


class Interruption:
    """The end of the last time in which the autopilot was not heard, or this program paused.

    A failsafe's hold soon after that is the loss of our stream, not a pilot's decision.
    """

    def __init__(self) -> None:
        self._stepped_s = self._ended_s = -math.inf

    def step(self, now_s: float, is_quiet: bool) -> None:
        """Takes whether the autopilot is not heard now; once a tick."""
        if is_quiet or now_s - self._stepped_s >= QUIET_S:
            self._ended_s = now_s
        self._stepped_s = now_s

    def forget(self) -> None:
        """Nothing that follows is attributed to the interruption."""
        self._ended_s = -math.inf

    @property
    def is_recent(self) -> bool:
        """Whether a failsafe may be due to the interruption."""
        return self._stepped_s - self._ended_s <= FOLLOWS_S


class HeardTime:
    """The time in which the autopilot was heard.

    >>> time = HeardTime()
    >>> for now_s in (10.0, 10.25, 10.5, 10.75, 60.0):
    ...     time.step(now_s, is_heard=now_s < 10.5)
    >>> time.seconds, time.is_quiet
    (0.75, True)

    Attributes:
        seconds: that time, since the first step.
        is_quiet: the autopilot is not heard now.
    """

    def __init__(self) -> None:
        self.seconds = 0.0
        self.is_quiet = True
        self._heard_s = -math.inf
        self._stepped_s: float | None = None

    def step(self, now_s: float, is_heard: bool) -> None:
        """Advances the clock; `is_heard` says whether anything has arrived since the last step."""
        passed_s = now_s - (now_s if self._stepped_s is None else self._stepped_s)
        self._stepped_s = now_s
        if is_heard:
            self._heard_s = now_s
        self.is_quiet = now_s - self._heard_s > QUIET_S
        if not self.is_quiet:
            self.seconds += passed_s
