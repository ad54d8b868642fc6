"""Where the vehicle was, and how it was turned, in the last second: what a sighting is placed by.

Positions and attitudes come in messages of their own, in the autopilot's time since boot; between
two of them the vehicle moves evenly.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import deque
from typing import NamedTuple

from companion.geometry import Ned, wrap_angle
from companion.mavlink.framing import Message
from companion.vehicle.mission_frame import MissionFrame

_KEPT = 20  # one of each per tick of 50 ms


class Pose(NamedTuple):
    """A position in the mission's frame, and roll, pitch and yaw."""

    position: Ned
    euler: Ned


class PoseHistory:
    """The poses of one vehicle.

    Attributes:
        newest_s: time since boot of the newest position; None before the first.
    """

    def __init__(self) -> None:
        self.newest_s: float | None = None
        self._positions: deque[tuple[float, Ned]] = deque(maxlen=_KEPT)
        self._eulers: deque[tuple[float, Ned]] = deque(maxlen=_KEPT)

    def take(self, message: Message, frame: MissionFrame) -> None:
        """A LOCAL_POSITION_NED or ATTITUDE; others, and numbers that are not finite, are passed.

        Args:
            message: of the autopilot.
            frame: of the mission; a position is taken once it is known.
        """
        kind = message.get_type()
        if kind == "LOCAL_POSITION_NED" and frame.is_known:
            local = (message.x, message.y, message.z)
            if all(map(math.isfinite, local)):
                self.newest_s = message.time_boot_ms / 1e3
                _keep(self._positions, (self.newest_s, frame.position(local)))
        elif kind == "ATTITUDE":
            euler = (message.roll, message.pitch, message.yaw)
            if all(map(math.isfinite, euler)):
                _keep(self._eulers, (message.time_boot_ms / 1e3, euler))

    def at(self, boot_s: float) -> Pose | None:
        """The pose at a time since boot; before and after all that are kept, the nearest one."""
        if not self._positions or not self._eulers:
            return None
        (_, a), (_, b), share = _around(self._positions, boot_s)
        north, east, down = (p + share * (q - p) for p, q in zip(a, b, strict=True))
        (_, a), (_, b), share = _around(self._eulers, boot_s)
        roll, pitch, yaw = (
            wrap_angle(p + share * wrap_angle(q - p)) for p, q in zip(a, b, strict=True)
        )
        return Pose((north, east, down), (roll, pitch, yaw))


def _around(
    entries: deque[tuple[float, Ned]], at_s: float
) -> tuple[tuple[float, Ned], tuple[float, Ned], float]:
    """The two entries around a time, and where it lies between them."""
    after = min(bisect_left([time_s for time_s, _ in entries], at_s), len(entries) - 1)
    if after == 0:
        return entries[0], entries[0], 0.0
    before = entries[after - 1]
    share = (at_s - before[0]) / (entries[after][0] - before[0])
    return before, entries[after], min(max(share, 0.0), 1.0)


def _keep(entries: deque[tuple[float, Ned]], entry: tuple[float, Ned]) -> None:
    """Entries are in the order of time; one from before the others begins anew (a restart)."""
    if entries and entry[0] < entries[-1][0]:
        entries.clear()
    if not entries or entry[0] > entries[-1][0]:
        entries.append(entry)
