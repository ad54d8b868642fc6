"""Places range scans (OBSTACLE_DISTANCE) by where the vehicle was when they were measured.

At full speed and turning the far end of a scan moves by a metre in the time between two messages,
and messages overtake each other. So positions and attitudes of the last second are kept, and a scan
is placed between those at its own time, by the autopilot's clock. One that is much newer than all
of them (AHEAD_S) waits. A scanner whose clock is not the autopilot's (further apart than
MOST_APART_S) is taken to have measured when the last position was.

Source: common.xml. Distances are centimetres; max_distance + 1 means nothing is there, 65535 not
known. increment_f replaces increment if it is not zero. Scans that are fixed to the vehicle
(MAV_FRAME_BODY_FRD) lean with it. Those that are fixed to north (MAV_FRAME_GLOBAL) come from a
program that has turned them, and are level. No others are understood.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from companion.geometry import Ned, wrap_angle
from companion.mavlink.framing import Message, dialect
from companion.motion.position_error import height_error_m
from companion.motion.range_scan import RangeScan
from companion.vehicle.mission_frame import MissionFrame
from companion.vehicle.poses import Pose

AHEAD_S = 0.05
"""How far position and attitude are carried on, along the line through the last two."""
MOST_APART_S = 0.5
Entry = tuple[float, Ned]
"""A time since boot, and a position, or roll, pitch and yaw."""

LEAST_STEP_DEG = 0.01
"""Between two beams; what says less, or more than a turn, is no scan."""
LEAST_UPRIGHT = 0.5
"""Cosine of the tilt of a vehicle beyond which its scans are not used: 60 degrees."""
POSES = frozenset({"LOCAL_POSITION_NED", "ATTITUDE"})
"""Messages that place scans."""

_KEPT = 20  # one of each per tick of 50 ms
_UNKNOWN_CM = 65535
_FRAMES = (dialect.MAV_FRAME_GLOBAL, dialect.MAV_FRAME_BODY_FRD)


class Ranging:
    """Scans that were heard, placed by the positions around them."""

    def __init__(self) -> None:
        self._positions: deque[Entry] = deque(maxlen=_KEPT)
        self._eulers: deque[Entry] = deque(maxlen=_KEPT)
        self._waiting: deque[Message] = deque(maxlen=_KEPT)

    def take_pose(self, message: Message, frame: MissionFrame) -> None:
        """One of POSES; others, and numbers that are not finite, are passed.

        Args:
            frame: of the mission; a position is taken once it is known.
        """
        kind = message.get_type()
        if kind == "LOCAL_POSITION_NED" and math.isfinite(message.x + message.y + message.z):
            if frame.is_known:
                position = frame.position((message.x, message.y, message.z))
                _keep(self._positions, (message.time_boot_ms / 1e3, position))
        elif kind == "ATTITUDE" and math.isfinite(message.roll + message.pitch + message.yaw):
            euler = (message.roll, message.pitch, message.yaw)
            _keep(self._eulers, (message.time_boot_ms / 1e3, euler))

    def take_scan(self, message: Message) -> None:
        """An OBSTACLE_DISTANCE."""
        self._waiting.append(message)

    def scans(self, now_s: float, accuracy_m: float, below_m: float | None) -> list[RangeScan]:
        """The scans that can be placed by now, in the mission's frame.

        Args:
            now_s: the time of the companion, which they are stamped with.
            accuracy_m: of the position.
            below_m: the distance to what is below the vehicle, as `height_error_m` takes it.
        """
        found: list[RangeScan] = []
        for _ in range(len(self._waiting)):
            message = self._waiting.popleft()
            boot_s = message.time_usec / 1e6
            if self._is_ahead(boot_s):
                self._waiting.append(message)
            elif pose := self._pose(boot_s):
                height_off_m = height_error_m(accuracy_m, -pose.position[2], below_m)
                scan = range_scan(message, now_s, pose, height_off_m)
                found += [scan] if scan else []
        return found

    def _is_ahead(self, boot_s: float) -> bool:
        """Whether a time is one of those for which a position is still to come."""
        if not self._positions or not self._eulers:
            return False
        ahead_s = boot_s - min(self._positions[-1][0], self._eulers[-1][0])
        return AHEAD_S < ahead_s < MOST_APART_S

    def _pose(self, boot_s: float) -> Pose | None:
        """Position and attitude at a time of the autopilot; None until both are known."""
        if not self._positions or not self._eulers:
            return None
        first, last, share = _around(self._positions, boot_s)
        north, east, down = (a + share * (b - a) for a, b in zip(first, last, strict=True))
        first, last, share = _around(self._eulers, boot_s)
        roll, pitch, yaw = (
            wrap_angle(a + share * wrap_angle(b - a)) for a, b in zip(first, last, strict=True)
        )
        return Pose((north, east, down), (roll, pitch, yaw))


def range_scan(message: Message, now_s: float, pose: Pose, height_off_m: float) -> RangeScan | None:
    """An OBSTACLE_DISTANCE as a scan; None if it is not understood.

    Args:
        now_s: when it was heard.
        pose: of the vehicle, when it was measured.
        height_off_m: what its height may be off by.
    """
    step_deg = message.increment_f or message.increment
    is_turn = LEAST_STEP_DEG <= abs(step_deg) <= 360.0  # and so a number
    is_number = is_turn and math.isfinite(message.angle_offset)
    if message.frame not in _FRAMES or not is_number or not message.max_distance:
        return None
    is_fixed_to_vehicle = message.frame == dialect.MAV_FRAME_BODY_FRD
    roll, pitch, yaw = pose.euler if is_fixed_to_vehicle else (0.0, 0.0, 0.0)
    if math.cos(roll) * math.cos(pitch) < LEAST_UPRIGHT:
        return None
    count = min(len(message.distances), int(360 / abs(step_deg) + 1e-6))
    distances_cm = np.array(message.distances[:count], dtype=np.float64)
    distances_m = np.where(distances_cm > message.max_distance, np.inf, distances_cm / 100)
    distances_m[distances_cm == _UNKNOWN_CM] = np.nan
    north, east, down = pose.position
    return RangeScan(
        stamp_s=now_s,
        position=(north, east),
        distances_m=distances_m,
        first_rad=math.radians(message.angle_offset),
        step_rad=math.radians(step_deg),
        range_m=message.max_distance / 100,
        up_m=-down,
        yaw_rad=yaw,
        tilt_rad=(roll, pitch),
        height_error_m=height_off_m,
    )


def _around(entries: deque[Entry], at_s: float) -> tuple[Ned, Ned, float]:
    """The two entries around a time, and where it lies between them; beyond the last, above 1."""
    after = len(entries) - 1
    if after == 0 or abs(at_s - entries[after][0]) >= MOST_APART_S:
        return entries[after][1], entries[after][1], 0.0
    while after > 1 and entries[after - 1][0] >= at_s:
        after -= 1
    (before_s, first), (after_s, last) = entries[after - 1], entries[after]
    return first, last, max(0.0, (at_s - before_s) / (after_s - before_s))


def _keep(entries: deque[Entry], entry: Entry) -> None:
    """Entries are in the order of time; one from before the others begins anew (a restart)."""
    if entries and entry[0] < entries[-1][0]:
        entries.clear()
    if not entries or entry[0] > entries[-1][0]:
        entries.append(entry)
