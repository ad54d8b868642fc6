"""Headings: where a vehicle looks, how near is near enough, and how fast it turns.

Angles are radians clockwise from north, as PX4 and MAVLink have the yaw: north is that of the
autopilot's local frame (NED), and the mission's frame is not turned against it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.geometry import NorthEast, horizontal_distance, wrap_angle

HEADING_TOLERANCE_RAD = math.radians(5.0)
"""How near the heading has to be to one that is asked for. PX4's own missions accept 12 degrees
(MIS_YAW_ERR); a picture that is to show something wants less, and a vehicle that hovers keeps its
heading better than that."""
FACING_M = 0.5
"""A point nearer than this, horizontally, lies in no certain direction: an estimate of the position
that wanders by 0.3 m would turn the vehicle to and fro. PX4 keeps the heading there too, within its
acceptance radius."""

BEAM_RAD = math.radians(5.0)
"""From one beam of a range finder to the next, where OBSTACLE_DISTANCE has a turn in 72 parts."""
GLANCE_S = 4.0
"""Of a turn to and fro by that much; scans at 10 Hz pass each cell 5 m away several times."""


def glance(time_s: float) -> float:
    """How far a vehicle that looks around is turned aside at a time, rad: to and fro, evenly.

    >>> [round(math.degrees(glance(second)), 1) for second in (0.0, 1.0, 2.0, 3.0, 4.0)]
    [0.0, 2.5, 5.0, 2.5, 0.0]
    """
    half = GLANCE_S / 2
    return BEAM_RAD * (1 - abs(time_s % GLANCE_S - half) / half)


def towards(position: Sequence[float], point: NorthEast) -> float | None:
    """The heading with which one looks at a point; None if it is too near to tell.

    >>> towards((0.0, 0.0, -2.0), (0.0, -3.0)) == -math.pi / 2  # in the west
    True
    """
    if horizontal_distance(position, point) < FACING_M:
        return None
    return math.atan2(point[1] - position[1], point[0] - position[0])


def turned(now_rad: float, wanted_rad: float, most_rad: float) -> float:
    """A heading that is turned to another one, the shorter way, by so much at most.

    >>> round(math.degrees(turned(math.radians(170), math.radians(-170), math.radians(15))))
    -175
    """
    turn_rad = wrap_angle(wanted_rad - now_rad)
    return wrap_angle(now_rad + math.copysign(min(abs(turn_rad), most_rad), turn_rad))


def error_rad(now_rad: float, wanted_rad: float) -> float:
    """The angle between two headings, 0 to pi."""
    return abs(wrap_angle(wanted_rad - now_rad))
