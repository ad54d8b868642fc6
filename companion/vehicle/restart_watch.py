"""Counts how often an autopilot has restarted, by the time since boot in one of its messages.

A restart in the air stops the motors. The vehicle falls, and then lies disarmed on the ground like
one that has landed. Only the clock tells the two apart.

Rules:
1. Each stamp follows the one before within STEP_S. One that does not is a stray, or follows a gap.
2. SURE stamps in a row that follow each other are the clock. If they lie behind the earlier clock,
   the autopilot has restarted.
3. Until that is decided, and while the clock is not heard, the number of restarts is uncertain.
"""

from __future__ import annotations

import math

from companion.vehicle.heard_time import QUIET_S

STEP_S = 1.0
"""Greatest difference of successive stamps: a PX4 sends its attitude at 50 Hz."""
SURE = 5
"""Stamps, so that a damaged, forged or late one is not taken for a restart."""


class RestartWatch:
    """Takes the stamps of one kind of message, in the order in which they are heard.

    >>> watch = RestartWatch()
    >>> for now_s, boot_s in enumerate((100.0, 101.0, 3.0, 102.0, 4.0, 4.5, 5.0, 5.5)):
    ...     watch.take(now_s, boot_s)
    >>> watch.restarts, watch.is_certain(7.0)
    (0, False)
    >>> watch.take(8.0, 6.0)
    >>> watch.restarts, watch.is_certain(8.0), watch.is_certain(9.0)
    (1, True, False)

    Attributes:
        restarts: how often the clock has started anew.
    """

    def __init__(self) -> None:
        self.restarts = 0
        self._heard_s = -math.inf
        self._clock_s: float | None = None
        self._other_s = 0.0
        self._others = 0

    def take(self, now_s: float, boot_s: float) -> None:
        """Takes a stamp.

        Args:
            now_s: when it was heard.
            boot_s: the time since the boot.
        """
        self._heard_s = now_s
        if self._clock_s is None or abs(boot_s - self._clock_s) <= STEP_S:
            self._clock_s, self._others = boot_s, 0
            return
        goes_on = self._others > 0 and abs(boot_s - self._other_s) <= STEP_S
        self._others = self._others + 1 if goes_on else 1
        self._other_s = boot_s
        if self._others >= SURE:
            self.restarts += boot_s < self._clock_s
            self._clock_s, self._others = boot_s, 0

    def is_certain(self, now_s: float) -> bool:
        """Whether `restarts` is certain to be up to date."""
        return not self._others and now_s - self._heard_s <= QUIET_S
