"""The steps of skills that use payloads; they are done once their effect has been observed."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Photo:
    """Primitive: take one photo; done when the camera has stored it.

    Attributes:
        component: MAVLink component id of the camera.
        camera: its name in the mission.
    """

    component: int
    camera: str


@dataclass(frozen=True, slots=True)
class PointGimbal:
    """Primitive: point a gimbal; done when it points there.

    Attributes:
        component: MAVLink component id of the gimbal's manager.
        gimbal: its name in the mission.
        pitch_rad: up is positive.
        yaw_rad: clockwise from the vehicle's heading.
    """

    component: int
    gimbal: str
    pitch_rad: float
    yaw_rad: float
