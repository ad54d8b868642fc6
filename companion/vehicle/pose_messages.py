"""Stores the autopilot's positions and attitudes, by its time since boot, in a history of poses.

They come in LOCAL_POSITION_NED and ATTITUDE. None is stored while the mission's frame is in doubt,
so that no scan is placed by a position that may be wrong. Source: common.xml.
"""

from __future__ import annotations

import math

from companion.mavlink.framing import Message
from companion.vehicle.poses import PoseHistory
from companion.vehicle.telemetry import Telemetry

POSES = frozenset({"LOCAL_POSITION_NED", "ATTITUDE"})


def keep_pose(poses: PoseHistory, message: Message, telemetry: Telemetry) -> None:
    """Adds the pose in one of POSES; other messages, and numbers that are not finite, are ignored.

    Args:
        poses: of the vehicle, by the autopilot's time since boot.
        message: of the autopilot.
        telemetry: of the vehicle; positions are added once its mission's frame is known.
    """
    kind, frame = message.get_type(), telemetry.frame
    if kind not in POSES or telemetry.placed.doubt is not None:
        return
    if kind == "LOCAL_POSITION_NED" and frame.is_known:
        local = (message.x, message.y, message.z)
        if all(map(math.isfinite, local)):
            poses.add_position(message.time_boot_ms / 1e3, frame.position(local))
    elif kind == "ATTITUDE":
        euler = (message.roll, message.pitch, message.yaw)
        if all(map(math.isfinite, euler)):
            poses.add_attitude(message.time_boot_ms / 1e3, euler)
