"""Headings: the heading towards a point, when a heading is good enough, and how fast it turns.

Angles are in radians clockwise from north, like the yaw of PX4 and MAVLink. North is that of the
autopilot's local frame (NED); the mission's frame is not rotated against it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.geometry import NorthEast, horizontal_distance, wrap_angle

HEADING_TOLERANCE_RAD = math.radians(5.0)
"""The greatest error of a heading that counts as reached. PX4's own missions accept 12 degrees
(MIS_YAW_ERR). A picture of something needs less, and a vehicle that hovers holds its heading better
than that."""
FACING_M = 0.5
"""The direction to a point nearer than this, horizontally, is uncertain: a position estimate that
wanders by 0.3 m would turn the vehicle to and fro. Within its acceptance radius PX4 keeps the
heading, too."""

BEAM_RAD = math.radians(5.0)
"""The angle between two beams of a range finder, if OBSTACLE_DISTANCE divides the turn by 72."""
GLANCE_S = 4.0
"""Period of a turn to and fro by that much; scans at 10 Hz pass a cell 5 m away several times."""


def sweep_rad(time_s: float) -> float:
    """How far a vehicle that looks around is turned aside at a time, rad: to and fro, linearly.

    >>> [round(math.degrees(sweep_rad(second)), 1) for second in (0.0, 1.0, 2.0, 3.0, 4.0)]
    [0.0, 2.5, 5.0, 2.5, 0.0]
    """
    half = GLANCE_S / 2
    return BEAM_RAD * (1 - abs(time_s % GLANCE_S - half) / half)


def towards(position: Sequence[float], point: NorthEast) -> float | None:
    """The heading towards a point; None if the point is too near.

    >>> towards((0.0, 0.0, -2.0), (0.0, -3.0)) == -math.pi / 2  # in the west
    True
    """
    if horizontal_distance(position, point) < FACING_M:
        return None
    return math.atan2(point[1] - position[1], point[0] - position[0])


def turned(now_rad: float, wanted_rad: float, most_rad: float) -> float:
    """A heading turned towards another one, the shorter way round, by at most `most_rad`.

    >>> round(math.degrees(turned(math.radians(170), math.radians(-170), math.radians(15))))
    -175
    """
    turn_rad = wrap_angle(wanted_rad - now_rad)
    return wrap_angle(now_rad + math.copysign(min(abs(turn_rad), most_rad), turn_rad))


def error_rad(now_rad: float, wanted_rad: float) -> float:
    """The angle between two headings, 0 to pi."""
    return abs(wrap_angle(wanted_rad - now_rad))
