"""Keeps the vehicle's recent positions and attitudes, to place scans, markers and reports.

Positions and attitudes come in separate messages. Both are interpolated linearly between two
samples. Before the first sample that is kept, and after the last, that sample is used.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import deque
from operator import itemgetter
from typing import NamedTuple

from companion.geometry import Ned, wrap_angle

KEPT_S = 1.0


class Pose(NamedTuple):
    """A position in the mission's frame; roll, pitch and yaw, rad."""

    position: Ned
    euler: Ned


class PoseHistory:
    """The vehicle's poses of the last seconds, by one clock.

    Args:
        kept_s: how long a pose is kept.
    """

    def __init__(self, kept_s: float = KEPT_S) -> None:
        self._positions = _Samples(kept_s)
        self._eulers = _Samples(kept_s)

    def add_position(self, time_s: float, position: Ned) -> None:
        """Adds a position in the mission's frame."""
        self._positions.add(time_s, position)

    def add_attitude(self, time_s: float, euler: Ned) -> None:
        """Adds an attitude: roll, pitch and yaw, rad."""
        self._eulers.add(time_s, euler)

    def add(self, time_s: float, pose: Pose) -> None:
        """Adds a position and an attitude."""
        self.add_position(time_s, pose.position)
        self.add_attitude(time_s, pose.euler)

    @property
    def oldest_s(self) -> float | None:
        """The time of the oldest position; None before the first."""
        return self._positions.oldest_s

    @property
    def newest_s(self) -> float | None:
        """The time of the newest position; None before the first."""
        return self._positions.newest_s

    @property
    def complete_until_s(self) -> float | None:
        """Until when both position and attitude are known; None until both have come."""
        position_s, euler_s = self._positions.newest_s, self._eulers.newest_s
        return None if position_s is None or euler_s is None else min(position_s, euler_s)

    def at(self, time_s: float, ahead_s: float = 0.0) -> Pose | None:
        """The pose at a time; None until both position and attitude have come.

        >>> from companion.vehicle.poses import Pose, PoseHistory
        >>> poses = PoseHistory()
        >>> poses.add(1.0, Pose((0.0, 0.0, -5.0), (0.0, 0.0, 0.0)))
        >>> poses.add(1.1, Pose((2.0, 0.0, -5.0), (0.0, 0.0, 0.2)))
        >>> [round(x, 6) for x in poses.at(1.05).position]
        [1.0, 0.0, -5.0]

        Args:
            time_s: by the clock of the history.
            ahead_s: greatest time by which the motion of the last two samples is extrapolated.
        """
        if self.complete_until_s is None:
            return None
        first, last, share = self._positions.around(time_s, ahead_s)
        north, east, down = (a + share * (b - a) for a, b in zip(first, last, strict=True))
        first, last, share = self._eulers.around(time_s, ahead_s)
        roll, pitch, yaw = (
            wrap_angle(a + share * wrap_angle(b - a)) for a, b in zip(first, last, strict=True)
        )
        return Pose((north, east, down), (roll, pitch, yaw))


class _Samples:
    """Vectors of three numbers with their times, in order."""

    def __init__(self, kept_s: float) -> None:
        self._kept_s = kept_s
        self._entries: deque[tuple[float, Ned]] = deque()

    @property
    def oldest_s(self) -> float | None:
        return self._entries[0][0] if self._entries else None

    @property
    def newest_s(self) -> float | None:
        return self._entries[-1][0] if self._entries else None

    def add(self, time_s: float, value: Ned) -> None:
        """Adds a sample. A step back in time means that the clock was reset (a restart): starts
        anew.
        """
        entries = self._entries
        if entries and time_s < entries[-1][0]:
            entries.clear()
        if not entries or time_s > entries[-1][0]:
            entries.append((time_s, value))
        while time_s - entries[0][0] > self._kept_s:
            entries.popleft()

    def around(self, time_s: float, ahead_s: float) -> tuple[Ned, Ned, float]:
        """The two samples around a time, and its fraction between them; above 1 beyond the last.

        Requires at least one sample.
        """
        entries = self._entries
        time_s = min(time_s, entries[-1][0] + ahead_s)
        after = min(bisect_left(entries, time_s, key=itemgetter(0)), len(entries) - 1)
        if after == 0:
            return entries[0][1], entries[0][1], 0.0
        (before_s, first), (after_s, last) = entries[after - 1], entries[after]
        return first, last, (time_s - before_s) / (after_s - before_s)
