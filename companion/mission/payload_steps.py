"""The steps of skills that act on payloads and are done when their effect was observed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Photo:
    """Primitive: make one photo, which is done when the camera has it.

    Attributes:
        component: MAVLink component id of the camera.
        camera: its name in the mission.
    """

    component: int
    camera: str


@dataclass(frozen=True, slots=True)
class PointGimbal:
    """Primitive: point a gimbal, which is done when it points there.

    Attributes:
        component: MAVLink component id of its manager.
        gimbal: its name in the mission.
        pitch_rad: up is positive.
        yaw_rad: clockwise from the vehicle's heading.
    """

    component: int
    gimbal: str
    pitch_rad: float
    yaw_rad: float
