"""Frames, angles and polygons: the only module that converts coordinates.

Inside the program everything is local NED in metres and radians, with the origin at the home
position. ENU with up positive, and degrees, exist only in YAML files and in what people read.

Sources: the azimuthal equidistant projection is PX4's `MapProjection` (a sphere of
6371000 m); quaternions are (w, x, y, z), body to NED, Hamilton convention.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, Self, TypeVar

Ned = tuple[float, float, float]
"""North, east, down; metres, or metres per second."""

NorthEast = tuple[float, float]
"""North, east; metres."""

Quaternion = tuple[float, float, float, float]
"""w, x, y, z; rotates body (forward, right, down) into NED."""

SAME_M = 0.2
"""Corners and points that an autopilot stores are equal if they are nearer to each other than this;
the mission protocol rounds to a centimetre."""

FAR_M = 10_000
"""Nothing of a mission or its world is farther from home; a larger value has another unit."""

EARTH_RADIUS_M = 6_371_000.0  # PX4, src/lib/geo/geo.h
GRAVITY_MPS2 = 9.80665  # standard gravity, CGPM 1901; as in PX4


def ned_from_enu(east_m: float, north_m: float, up_m: float) -> Ned:
    """Local NED of an ENU position.

    >>> ned_from_enu(1.0, 2.0, 3.0)
    (2.0, 1.0, -3.0)
    """
    return (north_m, east_m, -up_m)


def enu_from_ned(ned: Ned) -> tuple[float, float, float]:
    """East, north, up of a local NED position; the inverse of `ned_from_enu`."""
    return (ned[1], ned[0], -ned[2])


def wrap_angle(angle_rad: float) -> float:
    """The same direction in (-pi, pi].

    >>> round(wrap_angle(3 * math.pi), 6) == round(math.pi, 6)
    True
    """
    wrapped = math.remainder(angle_rad, 2 * math.pi)
    return math.pi if wrapped == -math.pi else wrapped


def horizontal_distance(a: Sequence[float], b: Sequence[float]) -> float:
    """Distance in the north-east plane, metres."""
    return math.hypot(a[0] - b[0], a[1] - b[1])


def distance(a: Ned, b: Ned) -> float:
    """Distance in space, metres."""
    return math.dist(a, b)


def times(vector: Ned, factor: float) -> Ned:
    """A vector times a factor."""
    north, east, down = vector
    return (north * factor, east * factor, down * factor)


def moved(point: Ned, by: Ned, factor: float) -> Ned:
    """A point, shifted by a multiple of a vector.

    >>> moved((1.0, 2.0, 3.0), (0.0, 0.0, -1.0), 0.5)
    (1.0, 2.0, 2.5)
    """
    return (
        point[0] + factor * by[0],
        point[1] + factor * by[1],
        point[2] + factor * by[2],
    )


def quaternion_from_yaw(yaw_rad: float) -> Quaternion:
    """The attitude of a level vehicle."""
    return (math.cos(yaw_rad / 2), 0.0, 0.0, math.sin(yaw_rad / 2))


def euler_from_quaternion(q: Quaternion) -> tuple[float, float, float]:
    """Roll, pitch, yaw in radians (Tait-Bryan, z-y'-x'')."""
    w, x, y, z = q
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return (roll, pitch, yaw)


def body_plane(roll_rad: float, pitch_rad: float, yaw_rad: float) -> tuple[Ned, Ned]:
    """A vehicle's forward and right directions, as unit vectors in NED.

    >>> forward, right = body_plane(0.0, math.radians(90), math.radians(90))
    >>> [round(x) for x in forward], [round(x) for x in right]
    ([0, 0, -1], [-1, 0, 0])
    """
    (sin_r, cos_r), (sin_p, cos_p), (sin_y, cos_y) = (
        (math.sin(angle), math.cos(angle)) for angle in (roll_rad, pitch_rad, yaw_rad)
    )
    return (
        (cos_p * cos_y, cos_p * sin_y, -sin_p),
        (
            sin_r * sin_p * cos_y - cos_r * sin_y,
            sin_r * sin_p * sin_y + cos_r * cos_y,
            sin_r * cos_p,
        ),
    )


def is_in_polygon(point: Sequence[float], polygon: Sequence[NorthEast]) -> bool:
    """Whether a point lies inside a simple polygon (even-odd rule).

    >>> is_in_polygon((1, 1), [(0, 0), (0, 2), (2, 2), (2, 0)])
    True
    """
    north, east = point[0], point[1]
    inside = False
    n1, e1 = polygon[-1]
    for n2, e2 in polygon:
        if (e1 > east) != (e2 > east) and north < (n2 - n1) * (east - e1) / (e2 - e1) + n1:
            inside = not inside
        n1, e1 = n2, e2
    return inside


class Located(Protocol):
    """Something with a place, that may be compared with another of its kind."""

    def is_like(self, other: Self, within_m: float, /) -> bool:
        """Whether both are the same, no further apart than that."""


AnyLocated = TypeVar("AnyLocated", bound=Located)


def are_alike(these: Sequence[AnyLocated], those: Sequence[AnyLocated], within_m: float) -> bool:
    """Whether two lists have the same parts, in any order."""
    if len(these) != len(those):
        return False
    left = list(those)
    for one in these:
        same = next((other for other in left if one.is_like(other, within_m)), None)
        if same is None:
            return False
        left.remove(same)
    return True


@dataclass(frozen=True, slots=True)
class GlobalOrigin:
    """Where local NED (0, 0, 0) lies on the earth."""

    latitude_deg: float
    longitude_deg: float
    altitude_m: float  # above mean sea level

    def __str__(self) -> str:
        return f"{self.latitude_deg},{self.longitude_deg},{self.altitude_m}"

    def to_global(self, ned: Ned) -> tuple[float, float, float]:
        """Latitude and longitude in degrees and altitude above mean sea level in metres.

        Beyond the 180th meridian the longitude continues from -180.
        """
        north, east = ned[0] / EARTH_RADIUS_M, ned[1] / EARTH_RADIUS_M
        c = math.hypot(north, east)
        lat0, lon0 = math.radians(self.latitude_deg), math.radians(self.longitude_deg)
        if c < 1e-12:
            return (self.latitude_deg, self.longitude_deg, self.altitude_m - ned[2])
        sin_c, cos_c = math.sin(c), math.cos(c)
        lat = math.asin(cos_c * math.sin(lat0) + north * sin_c * math.cos(lat0) / c)
        lon = lon0 + math.atan2(
            east * sin_c, c * math.cos(lat0) * cos_c - north * math.sin(lat0) * sin_c
        )
        east_deg = math.remainder(math.degrees(lon), 360.0)
        return (math.degrees(lat), east_deg, self.altitude_m - ned[2])

    def to_local(self, latitude_deg: float, longitude_deg: float, altitude_m: float) -> Ned:
        """Local NED of a global position; the inverse of `to_global`."""
        lat0, lat = math.radians(self.latitude_deg), math.radians(latitude_deg)
        d_lon = math.radians(longitude_deg - self.longitude_deg)
        cos_c = math.sin(lat0) * math.sin(lat) + math.cos(lat0) * math.cos(lat) * math.cos(d_lon)
        c = math.acos(max(-1.0, min(1.0, cos_c)))
        k = 1.0 if c < 1e-9 else c / math.sin(c)
        north = k * (
            math.cos(lat0) * math.sin(lat) - math.sin(lat0) * math.cos(lat) * math.cos(d_lon)
        )
        east = k * math.cos(lat) * math.sin(d_lon)
        return (north * EARTH_RADIUS_M, east * EARTH_RADIUS_M, self.altitude_m - altitude_m)
