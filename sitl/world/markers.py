"""Landing markers, and the camera on board that looks down for them.

The camera looks along the body's down axis, so a tilt shifts what it sees. It sees all markers that
are present, within its range of distances and its field of view. Its error is an angle, so a nearer
marker is measured better. It misses some looks, and sometimes mistakes something else for a marker.
Occlusion is not modelled.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from enum import StrEnum
from random import Random
from typing import NamedTuple

from companion.geometry import Ned, NorthEast, Quaternion
from sitl.flight.physics import FlightState

STRAY_M = 3.0
"""Standard deviation of the position of a false detection, in metres."""


class MarkerReport(StrEnum):
    """The form in which LANDING_TARGET reports a marker's position."""

    LOCAL_NED = "LOCAL_NED"
    BODY_FRD = "BODY_FRD"
    LOCAL_FRD = "LOCAL_FRD"
    ANGLES = "angles"


@dataclass(frozen=True, slots=True)
class Marker:
    """A marker.

    Attributes:
        name: for events.
        number: its target_num, which the camera reads from it.
        position: now, or at `since_s` if it moves.
        velocity: north and east.
        is_present: whether it can be seen.
        since_s: when this motion began.
    """

    name: str
    number: int
    position: Ned
    is_present: bool = True
    velocity: NorthEast = (0.0, 0.0)
    since_s: float = 0.0

    def at(self, now_s: float) -> Ned:
        """Its position at a time."""
        north, east, down = self.position
        moved_s = now_s - self.since_s
        return (north + self.velocity[0] * moved_s, east + self.velocity[1] * moved_s, down)


@dataclass(frozen=True, slots=True)
class MarkerChange:
    """A change of a marker; None leaves a property as it is."""

    name: str
    is_present: bool | None = None
    place: NorthEast | None = None
    velocity: NorthEast | None = None


@dataclass(frozen=True, slots=True)
class MarkerCameraSpec:
    """The properties of the camera.

    Attributes:
        component: its MAVLink component id.
        reports: the form of its reports.
        rate_hz: looks per second.
        nearest_m, range_m: distances between which a marker is seen.
        view_rad: the full angle of its field of view.
        noise_rad: standard deviation of the direction; the distance has it as a relative error.
        misses: share of looks in which a marker is not found.
        strays: share of looks with a false detection instead.
        markers: at the start.
    """

    component: int = 40
    reports: MarkerReport = MarkerReport.LOCAL_NED
    rate_hz: float = 20.0
    nearest_m: float = 0.3
    range_m: float = 12.0
    view_rad: float = math.radians(70.0)
    noise_rad: float = math.radians(0.5)
    misses: float = 0.0
    strays: float = 0.0
    markers: tuple[Marker, ...] = field(default=())


class Sighting(NamedTuple):
    """A marker as seen: the vector from the vehicle to it, in NED and in body axes."""

    number: int
    offset: Ned
    in_body: Ned


class MarkerCamera:
    """The camera and the markers of a world.

    Args:
        spec: its properties.
        rng: the source of its errors.
    """

    def __init__(self, spec: MarkerCameraSpec, rng: Random) -> None:
        self.spec = spec
        self._rng = rng
        self._markers = {marker.name: marker for marker in spec.markers}

    def change(self, change: MarkerChange, now_s: float) -> None:
        """Applies a change of the scenario to a marker."""
        marker = self._markers[change.name]
        position = marker.at(now_s)
        place = change.place or position[:2]
        self._markers[change.name] = replace(
            marker,
            position=(*place, position[2]),
            is_present=marker.is_present if change.is_present is None else change.is_present,
            velocity=marker.velocity if change.velocity is None else change.velocity,
            since_s=now_s,
        )

    def look(self, state: FlightState) -> list[Sighting]:
        """The sightings of one look, in the order of the file."""
        seen = (self._sighting(marker, state) for marker in self._markers.values())
        return [sighting for sighting in seen if sighting is not None]

    def _sighting(self, marker: Marker, state: FlightState) -> Sighting | None:
        offset = _minus(marker.at(state.time_s), state.position)
        distance_m = math.hypot(*offset)
        spec = self.spec
        if not marker.is_present or not spec.nearest_m <= distance_m <= spec.range_m:
            return None
        if _rotated(_conjugate(state.attitude), offset)[2] < distance_m * math.cos(
            spec.view_rad / 2
        ):
            return None
        if self._rng.random() < spec.misses:
            return None
        error_m = distance_m * spec.noise_rad
        stray_m = STRAY_M if self._rng.random() < spec.strays else 0.0
        north, east, down = (each + self._rng.gauss(0.0, error_m) for each in offset)
        if stray_m:
            north, east = north + self._rng.gauss(0.0, stray_m), east + self._rng.gauss(0, stray_m)
        measured = (north, east, down)
        return Sighting(marker.number, measured, _rotated(_conjugate(state.attitude), measured))


def _minus(a: Ned, b: Ned) -> Ned:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def _conjugate(q: Quaternion) -> Quaternion:
    return (q[0], -q[1], -q[2], -q[3])


def _rotated(q: Quaternion, vector: Ned) -> Ned:
    """A vector turned by a unit quaternion: v + 2 w (u x v) + 2 u x (u x v)."""
    w, *u = q
    once = _cross((u[0], u[1], u[2]), vector)
    twice = _cross((u[0], u[1], u[2]), once)
    north, east, down = (v + 2 * (w * a + b) for v, a, b in zip(vector, once, twice, strict=True))
    return (north, east, down)


def _cross(a: Ned, b: Ned) -> Ned:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
