"""The setpoint in a SET_POSITION_TARGET_LOCAL_NED or SET_POSITION_TARGET_GLOBAL_INT.

PX4 accepts frame 1 (MAV_FRAME_LOCAL_NED), and frame 8 (MAV_FRAME_BODY_NED) for velocity only. The
altitude of a global setpoint is above sea level (frames 0, 5) or above home (3, 6). A setpoint with
another frame, with a mask that ignores everything, or with a number that is not finite is dropped:
it counts as lost (as in PX4). Source: POSITION_TARGET_TYPEMASK in common.xml.
"""

from __future__ import annotations

import math

from companion.geometry import GlobalOrigin, Ned
from companion.mavlink.framing import Message
from sitl.flight.controllers import TrajectorySetpoint

LOCAL_NED, BODY_NED = 1, 8
LOCAL_FRAMES = (LOCAL_NED, BODY_NED)
ABOVE_SEA, ABOVE_HOME = (0, 5), (3, 6)
GLOBAL_FRAMES = ABOVE_SEA + ABOVE_HOME
FORCE_SET, YAW_IGNORE, YAW_RATE_IGNORE = 512, 1024, 2048
Triple = tuple[float | None, float | None, float | None]


def setpoint_from(
    message: Message, heading_rad: float, origin: GlobalOrigin, home_down_m: float
) -> TrajectorySetpoint | None:
    """The setpoint in a message.

    Args:
        message: SET_POSITION_TARGET_LOCAL_NED or SET_POSITION_TARGET_GLOBAL_INT.
        heading_rad: present heading, for a velocity along the body axes.
        origin: the origin of the local frame.
        home_down_m: height of home, local NED down.

    Returns:
        None for a message that PX4 would drop.
    """
    mask = message.type_mask
    is_global = message.get_type() == "SET_POSITION_TARGET_GLOBAL_INT"
    if is_global:
        here = _local(message, origin, home_down_m)
    else:
        here = (message.x, message.y, message.z)
    position = _unmasked(here, mask)
    velocity = _unmasked((message.vx, message.vy, message.vz), mask >> 3)
    acceleration = _unmasked((message.afx, message.afy, message.afz), mask >> 6)
    yaw = None if mask & YAW_IGNORE else message.yaw
    yaw_rate = None if mask & YAW_RATE_IGNORE else message.yaw_rate
    given = [v for v in (*position, *velocity, *acceleration) if v is not None]
    turning = [v for v in (yaw, yaw_rate) if v is not None]
    if not given or mask & FORCE_SET or not all(map(math.isfinite, (*given, *turning))):
        return None
    if message.coordinate_frame not in (GLOBAL_FRAMES if is_global else LOCAL_FRAMES):
        return None
    if message.coordinate_frame == BODY_NED:
        if any(v is not None for v in position) or None in velocity:
            return None
        velocity = _turned(velocity, heading_rad)
    north, east, down = (v or 0.0 for v in acceleration)
    return TrajectorySetpoint(position, velocity, (north, east, down), yaw, yaw_rate)


def _local(message: Message, origin: GlobalOrigin, home_down_m: float) -> Ned:
    north_m, east_m, down_m = origin.to_local(
        message.lat_int / 1e7, message.lon_int / 1e7, message.alt
    )
    above_home = message.coordinate_frame in ABOVE_HOME
    return (north_m, east_m, home_down_m - message.alt if above_home else down_m)


def _unmasked(values: tuple[float, float, float], mask: int) -> Triple:
    x, y, z = (None if mask & bit else v for v, bit in zip(values, (1, 2, 4), strict=True))
    return (x, y, z)


def _turned(velocity: Triple, heading_rad: float) -> Triple:
    forward, right, down = velocity
    assert forward is not None and right is not None
    c, s = math.cos(heading_rad), math.sin(heading_rad)
    return (c * forward - s * right, s * forward + c * right, down)
