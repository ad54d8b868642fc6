"""Markers on which a vehicle can land: what a mission says of one."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class LandingMarker:
    """A marker at a place, on which the vehicle can land.

    Attributes:
        component: MAVLink component id of who sees it.
        number: that is read off it, `target_num` of LANDING_TARGET.
        up_m: height of what it lies on, above home: 0 on the ground, or the end of a low wall.
    """

    component: int
    number: int
    up_m: float
