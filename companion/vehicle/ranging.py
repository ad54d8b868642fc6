"""Places range scans (OBSTACLE_DISTANCE) by where the vehicle was when they were measured.

At full speed and while turning, the far end of a scan moves by a metre in the time between two
messages, and messages overtake each other. So a scan is placed by the vehicle's pose at the scan's
own time, by the autopilot's clock.

1. A scan that is newer than all poses by more than AHEAD_S waits.
2. If the stamp and the poses are further apart than MOST_APART_S, the scanner has another clock.
   Its scan is then placed by the last position.
3. Scans fixed to the vehicle (MAV_FRAME_BODY_FRD) tilt with it. Scans fixed to north
   (MAV_FRAME_GLOBAL) come from a program that has rotated them, and are level. Others are dropped.

Source: common.xml. Distances are in centimetres; max_distance + 1 means that nothing is there,
65535 that nothing is known. increment_f replaces increment unless it is zero.
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
"""How far the motion between the last two poses is extrapolated."""
MOST_APART_S = 0.5

LEAST_STEP_DEG = 0.01
"""Between two beams; a message with less, or with more than a turn, is not a valid scan."""
LEAST_UPRIGHT = 0.5
"""Cosine of the tilt above which scans are not used: 60 degrees."""

_MOST_WAITING = 20  # one per tick of 50 ms
_UNKNOWN_CM = 65535
_FRAMES = (dialect.MAV_FRAME_GLOBAL, dialect.MAV_FRAME_BODY_FRD)


class Ranging:
    """Places scans by the poses around them.

    Args:
        poses: of the vehicle, by the autopilot's time since boot.
    """

    def __init__(self, poses: PoseHistory) -> None:
        self._poses = poses
        self._waiting: deque[Message] = deque(maxlen=_MOST_WAITING)

    def take_scan(self, message: Message) -> None:
        """Takes an OBSTACLE_DISTANCE."""
        self._waiting.append(message)

    def scans(self, now_s: float, accuracy_m: float, below_m: float | None) -> list[RangeScan]:
        """The scans that can be placed by now, in the mission's frame.

        Args:
            now_s: the companion's time, used as their stamp.
            accuracy_m: of the position.
            below_m: distance to what is below the vehicle, as `height_error_m` takes it.
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
        """Whether the pose for a time is still to come."""
        until_s = self._poses.complete_until_s
        return until_s is not None and AHEAD_S < boot_s - until_s < MOST_APART_S

    def _pose(self, boot_s: float) -> Pose | None:
        """The pose at a time of the autopilot; for a time of another clock, the newest pose."""
        newest_s = self._poses.newest_s
        if newest_s is not None and abs(boot_s - newest_s) >= MOST_APART_S:
            boot_s = newest_s
        return self._poses.at(boot_s, AHEAD_S)


def range_scan(message: Message, now_s: float, pose: Pose, height_off_m: float) -> RangeScan | None:
    """Converts an OBSTACLE_DISTANCE to a scan; None if it is not understood.

    Args:
        now_s: when it was heard.
        pose: of the vehicle when the scan was measured.
        height_off_m: greatest error of its height.
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
