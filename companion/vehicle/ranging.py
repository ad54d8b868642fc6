"""What does an OBSTACLE_DISTANCE say, and where was the vehicle when it was measured?

A scan is a little older or newer than the positions around it, and at full speed and turning its
far end moves by a metre meanwhile. So position and heading are carried along the line through the
last two that were heard, to the time of the scan. A scanner whose clock is not the autopilot's
(further apart than MOST_APART_S) is taken to have measured when the last position was.

Source: common.xml. Distances are centimetres; max_distance + 1 means nothing is there, 65535 not
known. increment_f replaces increment if it is not zero. Scans that are fixed to north
(MAV_FRAME_GLOBAL) or to the vehicle (MAV_FRAME_BODY_FRD) are understood, no others.
"""

from __future__ import annotations

import math

import numpy as np

from companion.geometry import NorthEast, wrap_angle
from companion.mavlink.framing import Message, dialect
from companion.motion.sensed_map import RangeScan

MOST_APART_S = 0.5
_UNKNOWN_CM = 65535
_FRAMES = (dialect.MAV_FRAME_GLOBAL, dialect.MAV_FRAME_BODY_FRD)


class Track:
    """The last two positions and headings in the autopilot's local frame, with its own times."""

    def __init__(self) -> None:
        self._positions: tuple[tuple[float, NorthEast], ...] = ()
        self._yaws: tuple[tuple[float, float], ...] = ()

    def take(self, message: Message) -> None:
        """A LOCAL_POSITION_NED or ATTITUDE; others, and numbers that are not finite, are passed."""
        kind = message.get_type()
        if kind == "LOCAL_POSITION_NED" and math.isfinite(message.x + message.y):
            now = (message.time_boot_ms / 1e3, (message.x, message.y))
            self._positions = (*self._positions[-1:], now)
        elif kind == "ATTITUDE" and math.isfinite(message.yaw):
            self._yaws = (*self._yaws[-1:], (message.time_boot_ms / 1e3, message.yaw))

    def pose(self, boot_s: float) -> tuple[NorthEast, float] | None:
        """North-east position and heading at a time of the autopilot; None until both are known."""
        if not self._positions or not self._yaws:
            return None
        (_, (n0, e0)), (_, (n1, e1)) = self._positions[0], self._positions[-1]
        share = _share([t for t, _ in self._positions], boot_s)
        position = (n1 + share * (n1 - n0), e1 + share * (e1 - e0))
        first, last = self._yaws[0][1], self._yaws[-1][1]
        turn = wrap_angle(last - first)
        return position, wrap_angle(last + _share([t for t, _ in self._yaws], boot_s) * turn)


def range_scan(message: Message, now_s: float, track: Track, home: NorthEast) -> RangeScan | None:
    """An OBSTACLE_DISTANCE in the mission's frame; None if it is not understood, or where is not.

    Args:
        now_s: when it was heard.
        home: origin of the mission's frame in the autopilot's local frame.
    """
    pose = track.pose(message.time_usec / 1e6)
    step_deg = message.increment_f or message.increment
    is_finite = math.isfinite(step_deg + message.angle_offset)
    if pose is None or message.frame not in _FRAMES or not is_finite or not step_deg:
        return None
    (north, east), yaw_rad = pose
    count = min(len(message.distances), int(360 / abs(step_deg) + 1e-6))
    distances_cm = np.array(message.distances[:count], dtype=np.float64)
    distances_m = np.where(distances_cm > message.max_distance, np.inf, distances_cm / 100)
    distances_m[distances_cm == _UNKNOWN_CM] = np.nan
    is_turned = message.frame == dialect.MAV_FRAME_BODY_FRD
    return RangeScan(
        stamp_s=now_s,
        position=(north - home[0], east - home[1]),
        distances_m=distances_m,
        first_rad=math.radians(message.angle_offset) + (yaw_rad if is_turned else 0.0),
        step_rad=math.radians(step_deg),
        range_m=message.max_distance / 100,
    )


def _share(times_s: list[float], at_s: float) -> float:
    """How far a time lies behind the last one, in units of the time between the two."""
    gap_s, away_s = times_s[-1] - times_s[0], at_s - times_s[-1]
    is_usable = 0 < gap_s < MOST_APART_S and abs(away_s) < MOST_APART_S
    return away_s / gap_s if is_usable else 0.0
