"""The models of a scenario file for landing markers and the camera that sees them."""

from __future__ import annotations

import math
from typing import Annotated

from companion.documents import Document, did_you_mean
from companion.errors import MissionError
from companion.geometry import FAR_M, NorthEast, ned_from_enu
from sitl.world.markers import Marker, MarkerCameraSpec, MarkerChange, MarkerReport
from sitl.world.schema_fields import (
    Component,
    East,
    EastSpeed,
    North,
    NorthSpeed,
    Strict,
    described,
)

Share = Annotated[float, described("share of the looks", ge=0, le=1)]


class MarkerModel(Strict):
    """A landing marker."""

    name: Annotated[str, described("its name, for events", min_length=1)]
    number: Annotated[
        int, described("the number that is read off the marker: its target_num", ge=0, le=255)
    ] = 0
    east_m: East
    north_m: North
    up_m: Annotated[float, described("metres above home", ge=-FAR_M, le=FAR_M)] = 0.0
    present: Annotated[bool, described("whether it is there at the start")] = True
    east_mps: EastSpeed = 0.0
    north_mps: NorthSpeed = 0.0


class MarkerCameraModel(Strict):
    """The camera that looks down for markers, and its markers."""

    component: Component = 40
    reports: Annotated[
        MarkerReport, described("the form of LANDING_TARGET; angles come with a distance")
    ] = MarkerReport.LOCAL_NED
    rate_hz: Annotated[float, described("pictures per second", gt=0, le=50)] = 20.0
    nearest_m: Annotated[float, described("markers nearer than this are not seen", ge=0)] = 0.3
    range_m: Annotated[float, described("markers farther than this are not seen", gt=0, le=600)] = (
        12.0
    )
    view_deg: Annotated[float, described("the whole angle of view", gt=0, le=170)] = 70.0
    noise_deg: Annotated[
        float,
        described("deviation of a direction; the distance deviates by the same share", ge=0, le=20),
    ] = 0.5
    misses: Annotated[Share, described("share of the sightings that are missed")] = 0.0
    strays: Annotated[
        Share, described("share of the sightings in which something else is taken for the marker")
    ] = 0.0
    markers: Annotated[
        tuple[MarkerModel, ...], described("the landing markers of the world", min_length=1)
    ]


class MarkerEventModel(Strict):
    """A marker appears, disappears, jumps or starts to move; keys left out change nothing."""

    name: Annotated[str, described("the name of one of the markers")]
    present: Annotated[bool | None, described("whether it is there")] = None
    east_m: Annotated[float | None, described("where it lies now", ge=-FAR_M, le=FAR_M)] = None
    north_m: Annotated[float | None, described("where it lies now", ge=-FAR_M, le=FAR_M)] = None
    east_mps: Annotated[float | None, described("m/s towards east, from now on", ge=-30, le=30)] = (
        None
    )
    north_mps: Annotated[
        float | None, described("m/s towards north, from now on", ge=-30, le=30)
    ] = None


def marker_camera(model: MarkerCameraModel, document: Document) -> MarkerCameraSpec:
    """The camera and its markers.

    Raises:
        MissionError: two markers have the same name.
    """
    names: set[str] = set()
    for i, entry in enumerate(model.markers):
        if entry.name in names:
            where = document.where("marker_camera", "markers", i, "name")
            raise MissionError(f"there are two markers {entry.name}", where)
        names.add(entry.name)
    return MarkerCameraSpec(
        model.component,
        model.reports,
        model.rate_hz,
        model.nearest_m,
        model.range_m,
        math.radians(model.view_deg),
        math.radians(model.noise_deg),
        model.misses,
        model.strays,
        tuple(_marker(entry) for entry in model.markers),
    )


def check_marker_event(
    event: MarkerEventModel, camera: MarkerCameraModel | None, document: Document, i: int
) -> None:
    """Refuses an event about an unknown marker, or one without an effect.

    Raises:
        MissionError: with the place in the file.
    """
    where = document.where("happens", i, "marker")
    if camera is None:
        hint = "describe it with the key marker_camera"
        raise MissionError("there is no camera for markers in this scenario", where, hint)
    names = [marker.name for marker in camera.markers]
    if event.name not in names:
        where = document.where("happens", i, "marker", "name")
        raise MissionError(
            f"there is no marker {event.name}", where, did_you_mean(event.name, names)
        )
    if (event.east_m is None) != (event.north_m is None):
        raise MissionError("a marker is laid at east_m and north_m, both", where)
    if event.model_fields_set == {"name"}:
        hint = "say present, east_m and north_m, or how fast it moves: east_mps, north_mps"
        raise MissionError(f"nothing becomes of the marker {event.name}", where, hint)


def marker_change(event: MarkerEventModel) -> MarkerChange:
    """The change that an event makes to a marker."""
    place: NorthEast | None = None
    if event.east_m is not None and event.north_m is not None:
        place = (event.north_m, event.east_m)
    velocity: NorthEast | None = None
    if event.east_mps is not None or event.north_mps is not None:
        velocity = (event.north_mps or 0.0, event.east_mps or 0.0)
    return MarkerChange(event.name, event.present, place, velocity)


def _marker(entry: MarkerModel) -> Marker:
    position = ned_from_enu(entry.east_m, entry.north_m, entry.up_m)
    velocity = (entry.north_mps, entry.east_mps)
    return Marker(entry.name, entry.number, position, entry.present, velocity)
