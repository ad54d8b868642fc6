"""The landing markers of a mission."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class LandingMarker:
    """A marker at a place, on which the vehicle can land.

    component: MAVLink component id of the component that sees the marker.
    number: the number on the marker, `target_num` of LANDING_TARGET.
    up_m: height above home of the surface that it lies on: 0 on the ground, or the top of a low
    wall.
    """

    component: int
    number: int
    up_m: float
