"""Places range scans (OBSTACLE_DISTANCE) by where the vehicle was when they were measured.

At full speed and turning the far end of a scan moves by a metre in the time between two messages,
and messages overtake each other. So positions and headings of the last second are kept, and a scan
is placed between those at its own time, by the autopilot's clock. One that is much newer than all
of them (AHEAD_S) waits. A scanner whose clock is not the autopilot's (further apart than
MOST_APART_S) is taken to have measured when the last position was.

Source: common.xml. Distances are centimetres; max_distance + 1 means nothing is there, 65535 not
known. increment_f replaces increment if it is not zero. Scans that are fixed to north
(MAV_FRAME_GLOBAL) or to the vehicle (MAV_FRAME_BODY_FRD) are understood, no others.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import deque
from typing import TypeVar

import numpy as np

from companion.geometry import NorthEast, wrap_angle
from companion.mavlink.framing import Message, dialect
from companion.motion.range_scan import RangeScan
from companion.vehicle.mission_frame import MissionFrame

AHEAD_S = 0.05
"""How far position and heading are carried on, along the line through the last two."""
MOST_APART_S = 0.5
Entry = TypeVar("Entry", tuple[float, float], tuple[float, float, float])

LEAST_STEP_DEG = 0.01
"""Between two beams; what says less, or more than a turn, is no scan."""
POSES = frozenset({"LOCAL_POSITION_NED", "ATTITUDE"})
"""Messages that place scans."""

_KEPT = 20  # one of each per tick of 50 ms
_UNKNOWN_CM = 65535
_FRAMES = (dialect.MAV_FRAME_GLOBAL, dialect.MAV_FRAME_BODY_FRD)


class Ranging:
    """Scans that were heard, placed by the positions around them."""

    def __init__(self) -> None:
        self._positions: deque[tuple[float, float, float]] = deque(maxlen=_KEPT)
        self._yaws: deque[tuple[float, float]] = deque(maxlen=_KEPT)
        self._waiting: deque[Message] = deque(maxlen=_KEPT)

    def take_pose(self, message: Message, frame: MissionFrame) -> None:
        """One of POSES; others, and numbers that are not finite, are passed.

        Args:
            frame: of the mission; a position is taken once it is known.
        """
        kind = message.get_type()
        if kind == "LOCAL_POSITION_NED" and math.isfinite(message.x + message.y):
            if frame.is_known:
                north, east, _ = frame.position((message.x, message.y, message.z))
                _keep(self._positions, (message.time_boot_ms / 1e3, north, east))
        elif kind == "ATTITUDE" and math.isfinite(message.yaw):
            _keep(self._yaws, (message.time_boot_ms / 1e3, message.yaw))

    def take_scan(self, message: Message) -> None:
        """An OBSTACLE_DISTANCE."""
        self._waiting.append(message)

    def scans(self, now_s: float) -> list[RangeScan]:
        """The scans that can be placed by now, in the mission's frame.

        Args:
            now_s: the time of the companion, which they are stamped with.
        """
        found: list[RangeScan] = []
        for _ in range(len(self._waiting)):
            message = self._waiting.popleft()
            boot_s = message.time_usec / 1e6
            if self._is_ahead(boot_s):
                self._waiting.append(message)
            elif pose := self._pose(boot_s):
                scan = range_scan(message, now_s, *pose)
                found += [scan] if scan else []
        return found

    def _is_ahead(self, boot_s: float) -> bool:
        """Whether a time is one of those for which a position is still to come."""
        if not self._positions or not self._yaws:
            return False
        ahead_s = boot_s - min(self._positions[-1][0], self._yaws[-1][0])
        return AHEAD_S < ahead_s < MOST_APART_S

    def _pose(self, boot_s: float) -> tuple[NorthEast, float] | None:
        """Position and heading at a time of the autopilot; None until both are known."""
        if not self._positions or not self._yaws:
            return None
        i, j, share = _around([t for t, *_ in self._positions], boot_s)
        (_, n0, e0), (_, n1, e1) = self._positions[i], self._positions[j]
        position = (n0 + share * (n1 - n0), e0 + share * (e1 - e0))
        i, j, share = _around([t for t, _ in self._yaws], boot_s)
        (_, first), (_, last) = self._yaws[i], self._yaws[j]
        return position, wrap_angle(first + share * wrap_angle(last - first))


def range_scan(
    message: Message, now_s: float, position: NorthEast, yaw_rad: float
) -> RangeScan | None:
    """An OBSTACLE_DISTANCE as a scan; None if it is not understood.

    Args:
        now_s: when it was heard.
        position: of the vehicle, when it was measured.
        yaw_rad: its heading at that time.
    """
    step_deg = message.increment_f or message.increment
    is_turn = LEAST_STEP_DEG <= abs(step_deg) <= 360.0  # and so a number
    if message.frame not in _FRAMES or not is_turn or not math.isfinite(message.angle_offset):
        return None
    count = min(len(message.distances), int(360 / abs(step_deg) + 1e-6))
    distances_cm = np.array(message.distances[:count], dtype=np.float64)
    distances_m = np.where(distances_cm > message.max_distance, np.inf, distances_cm / 100)
    distances_m[distances_cm == _UNKNOWN_CM] = np.nan
    is_turned = message.frame == dialect.MAV_FRAME_BODY_FRD
    return RangeScan(
        stamp_s=now_s,
        position=position,
        distances_m=distances_m,
        first_rad=math.radians(message.angle_offset) + (yaw_rad if is_turned else 0.0),
        step_rad=math.radians(step_deg),
        range_m=message.max_distance / 100,
    )


def _around(times_s: list[float], at_s: float) -> tuple[int, int, float]:
    """The two entries around a time, and where it lies between them; beyond the last, above 1."""
    last = len(times_s) - 1
    if last == 0 or abs(at_s - times_s[-1]) >= MOST_APART_S:
        return last, last, 0.0
    after = min(max(bisect_left(times_s, at_s), 1), last)
    before_s, after_s = times_s[after - 1], times_s[after]
    return after - 1, after, max(0.0, (at_s - before_s) / (after_s - before_s))


def _keep(entries: deque[Entry], entry: Entry) -> None:
    """Entries are in the order of time; one from before the others begins anew (a restart)."""
    if entries and entry[0] < entries[-1][0]:
        entries.clear()
    if not entries or entry[0] > entries[-1][0]:
        entries.append(entry)
