"""Converts our values to messages of Foxglove: metres east, north, up; on board x forward, y left.

Frames: the origin of `map` is the mission's home, with x to the east and y to the north.
`base_link` is the vehicle, but level: of its attitude a run shows only the heading.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from companion.geometry import Ned, enu_from_ned

MAP, VEHICLE = "map", "base_link"
NANO = 1_000_000_000
Content = dict[str, Any]


@dataclass(frozen=True, slots=True)
class LogMessage:
    """A message with its channel.

    Attributes:
        time_s: since the run began.
        topic: the topic of the channel.
        schema: its name.
        content: its fields, without a timestamp at the top level, which the file adds.
    """

    time_s: float
    topic: str
    schema: str
    content: Content


def stamp(unix_ns: int) -> Content:
    """A time, in nanoseconds since 1970.

    >>> stamp(1_700_000_000_250_000_000)
    {'sec': 1700000000, 'nsec': 250000000}
    """
    sec, nsec = divmod(unix_ns, NANO)
    return {"sec": sec, "nsec": nsec}


def vector(ned: Ned) -> Content:
    """A position in `map`, rounded to a millimetre."""
    x, y, z = (round(metres, 3) + 0.0 for metres in enu_from_ned(ned))
    return {"x": x, "y": y, "z": z}


def heading(yaw_rad: float | None) -> Content:
    """An orientation in `map` for a heading from north to east; None is that of the frame.

    >>> heading(math.pi / 2) == heading(None)  # to the east, along x
    True
    """
    half = 0.0 if yaw_rad is None else (math.pi / 2 - yaw_rad) / 2
    return {"x": 0.0, "y": 0.0, "z": round(math.sin(half), 6), "w": round(math.cos(half), 6)}


def pose(ned: Ned, yaw_rad: float | None = None) -> Content:
    """A pose in `map`."""
    return {"position": vector(ned), "orientation": heading(yaw_rad)}


def pose_in_map(ned: Ned, yaw_rad: float | None = None) -> Content:
    """The content of PoseInFrame."""
    return {"frame_id": MAP, "pose": pose(ned, yaw_rad)}


def poses_in_map(way: Iterable[Ned]) -> Content:
    """The content of PosesInFrame."""
    return {"frame_id": MAP, "poses": [pose(ned) for ned in way]}


def vehicle_in_map(ned: Ned, yaw_rad: float) -> Content:
    """The content of FrameTransform: where the vehicle is in `map`."""
    return {
        "parent_frame_id": MAP,
        "child_frame_id": VEHICLE,
        "translation": vector(ned),
        "rotation": heading(yaw_rad),
    }


def location(latitude_deg: float, longitude_deg: float, altitude_m: float) -> Content:
    """The content of LocationFix, of unknown accuracy."""
    return {
        "frame_id": VEHICLE,
        "latitude": latitude_deg,
        "longitude": longitude_deg,
        "altitude": altitude_m,
        "position_covariance": [0.0] * 9,
        "position_covariance_type": 0,
    }
