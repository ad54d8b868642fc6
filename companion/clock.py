"""Scaled real time. A door: it reads the machine's monotonic clock and sleeps."""

from __future__ import annotations

import math
import time
from collections.abc import Callable


class ScaledClock:
    """Time that runs `speed` times as fast as the machine's monotonic clock.

    Args:
        speed: scaled seconds per wall-clock second.
        max_jump_s: most wall-clock seconds that count between two readings; during a longer stall,
            the clock stands still for the rest.
        monotonic_s: reads the machine's clock.
        begin_s: its first reading, in scaled seconds.

    >>> readings = iter((50.0, 50.05, 60.0))
    >>> clock = ScaledClock(2.0, max_jump_s=0.1, monotonic_s=lambda: next(readings))
    >>> round(clock.now_s(), 6), round(clock.now_s(), 6)
    (0.1, 0.3)
    """

    def __init__(
        self,
        speed: float = 1.0,
        max_jump_s: float = math.inf,
        monotonic_s: Callable[[], float] = time.monotonic,
        begin_s: float = 0.0,
    ) -> None:
        self._speed = speed
        self._max_jump_s = max_jump_s
        self._is_machines = speed == 1.0 and max_jump_s == math.inf
        self._monotonic_s = monotonic_s
        self._read_s = monotonic_s()
        self._start_s = self._read_s - begin_s / speed

    def now_s(self) -> float:
        """Scaled seconds since the clock was made."""
        wall_s = self._monotonic_s()
        self._start_s += max(0.0, wall_s - self._read_s - self._max_jump_s)
        self._read_s = wall_s
        return (wall_s - self._start_s) * self._speed

    @property
    def zero_s(self) -> float | None:
        """What the machine's clock showed when this one showed 0; None if their rates differ."""
        return self._start_s if self._is_machines else None

    @property
    def speed(self) -> float:
        """Scaled seconds per wall-clock second."""
        return self._speed

    def speed_up(self, factor: float) -> None:
        """Runs faster by a factor, from the present reading."""
        now_s = self.now_s()
        self._speed *= factor
        self._start_s = self._read_s - now_s / self._speed
        self._is_machines = False

    def sleep_until(self, time_s: float) -> None:
        """Sleeps until a scaled time."""
        time.sleep(max(0.0, self.wall_s_until(time_s)))

    def wall_s_until(self, time_s: float) -> float:
        """Wall-clock seconds until a scaled time."""
        return (time_s - self.now_s()) / self._speed
