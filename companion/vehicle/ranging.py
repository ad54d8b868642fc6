"""Places range scans (OBSTACLE_DISTANCE) by where the vehicle was when they were measured.

At full speed and turning the far end of a scan moves by a metre in the time between two messages,
and messages overtake each other. So a scan is placed by the pose at its own time, by the
autopilot's clock. One that is much newer than all poses (AHEAD_S) waits. A scanner whose clock is
not the autopilot's (further apart than MOST_APART_S) is taken to have measured when the last
position was.

Source: common.xml. Distances are centimetres; max_distance + 1 means nothing is there, 65535 not
known. increment_f replaces increment if it is not zero. Scans that are fixed to the vehicle
(MAV_FRAME_BODY_FRD) lean with it. Those that are fixed to north (MAV_FRAME_GLOBAL) come from a
program that has turned them, and are level. No others are understood.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from companion.mavlink.framing import Message, dialect
from companion.motion.position_error import height_error_m
from companion.motion.range_scan import RangeScan
from companion.vehicle.poses import Pose, PoseHistory

AHEAD_S = 0.05
"""How far the motion between the last two poses is carried on."""
MOST_APART_S = 0.5

LEAST_STEP_DEG = 0.01
"""Between two beams; what says less, or more than a turn, is no scan."""
LEAST_UPRIGHT = 0.5
"""Cosine of the tilt of a vehicle beyond which its scans are not used: 60 degrees."""

_MOST_WAITING = 20  # one per tick of 50 ms
_UNKNOWN_CM = 65535
_FRAMES = (dialect.MAV_FRAME_GLOBAL, dialect.MAV_FRAME_BODY_FRD)


class Ranging:
    """Scans that were heard, placed by the poses around them.

    Args:
        poses: of the vehicle, by its autopilot's time since boot.
    """

    def __init__(self, poses: PoseHistory) -> None:
        self._poses = poses
        self._waiting: deque[Message] = deque(maxlen=_MOST_WAITING)

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
        """Whether a time is one of those for which a pose is still to come."""
        until_s = self._poses.complete_until_s
        return until_s is not None and AHEAD_S < boot_s - until_s < MOST_APART_S

    def _pose(self, boot_s: float) -> Pose | None:
        """The pose at a time of the autopilot; of another clock, the newest one."""
        newest_s = self._poses.newest_s
        if newest_s is not None and abs(boot_s - newest_s) >= MOST_APART_S:
            boot_s = newest_s
        return self._poses.at(boot_s, AHEAD_S)


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
