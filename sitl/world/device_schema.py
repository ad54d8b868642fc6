"""The scenario file's models of cameras, gimbal and gripper, and of the changes to them."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from companion.documents import Document
from companion.errors import MissionError
from companion.geometry import FAR_M
from sitl.world.camera import CameraChange, CameraSpec
from sitl.world.gimbal import GimbalChange, GimbalSpec
from sitl.world.gripper import GripperChange, GripperSpec
from sitl.world.schema_fields import Component, East, North, Strict, described
from sitl.world.visits import Circle

Share = Annotated[float, described("share of its messages about photos that are lost", ge=0, le=1)]
Duration = Annotated[float, described("seconds that a photo takes", ge=0, le=600)]
Which = Annotated[int | None, described("its component id; by default the first camera's")]


class DiscModel(Strict):
    """A circle on the ground."""

    east_m: East
    north_m: North
    radius_m: Annotated[float, described("metres", gt=0, le=FAR_M)]


class CameraModel(Strict):
    """A camera, by the camera protocol, version 2."""

    component: Component = 100
    after_s: Duration = 0.5
    images: Annotated[int, described("photos that it has already taken", ge=0, le=10**6)] = 0
    capacity: Annotated[
        int, described("the number of photos for which its storage has room", ge=0)
    ] = 1000
    fails: Annotated[tuple[DiscModel, ...], described("circles in which its photos fail")] = ()
    lost: Share = 0.0


class CameraEventModel(Strict):
    """A change of a camera; keys left out change nothing."""

    component: Which = None
    after_s: Annotated[float | None, described("seconds that a photo takes", ge=0, le=600)] = None
    busy: Annotated[bool | None, described("it rejects photos, temporarily")] = None
    fails: Annotated[bool | None, described("its photos fail, everywhere")] = None
    full: Annotated[bool | None, described("its storage has no room")] = None
    silent: Annotated[bool | None, described("it says nothing, and hears nothing")] = None
    lost: Annotated[
        float | None, described("share of the photos that it does not report", ge=0, le=1)
    ] = None


class GripperModel(Strict):
    """A gripper with a sensor that reads its load."""

    component: Component = 27
    after_s: Annotated[float, described("seconds that an action takes", ge=0, le=600)] = 1.0
    loads: Annotated[
        tuple[DiscModel, ...] | None,
        described("circles in which there is something to grab; by default everywhere"),
    ] = None


class GripperEventModel(Strict):
    """A change of the gripper; keys left out change nothing."""

    misses: Annotated[bool | None, described("it misses what is there")] = None
    drops: Annotated[Literal[True] | None, described("it loses its load now")] = None
    silent: Annotated[bool | None, described("it says nothing, and hears nothing")] = None


class GimbalModel(Strict):
    """A gimbal with its manager, by the gimbal protocol, version 2."""

    component: Component = 154
    rate_dps: Annotated[float, described("degrees a second that it turns", gt=0, le=720)] = 60.0
    pitch_deg: Annotated[tuple[float, float], described("[lowest, highest], up is positive")] = (
        -90.0,
        30.0,
    )


class GimbalEventModel(Strict):
    """A change of the gimbal; keys left out change nothing."""

    stuck: Annotated[bool | None, described("it does not turn")] = None
    taken: Annotated[Literal[True] | None, described("a ground station takes control")] = None
    silent: Annotated[bool | None, described("it says nothing, and hears nothing")] = None


def camera(model: CameraModel) -> CameraSpec:
    """The camera that a file describes."""
    fails = tuple(Circle((each.north_m, each.east_m), each.radius_m) for each in model.fails)
    return CameraSpec(
        model.component, model.after_s, model.images, model.capacity, fails, model.lost
    )


def camera_change(event: CameraEventModel) -> CameraChange:
    """The change that an event makes to a camera."""
    return CameraChange(
        event.component,
        event.after_s,
        event.busy,
        event.fails,
        event.full,
        event.silent,
        event.lost,
    )


def gripper(model: GripperModel) -> GripperSpec:
    """The gripper that a file describes."""
    loads = None
    if model.loads is not None:
        loads = tuple(Circle((each.north_m, each.east_m), each.radius_m) for each in model.loads)
    return GripperSpec(model.component, model.after_s, loads)


def gripper_change(event: GripperEventModel) -> GripperChange:
    """The change that an event makes to the gripper."""
    return GripperChange(event.misses, bool(event.drops), event.silent)


def gimbal(model: GimbalModel, document: Document) -> GimbalSpec:
    """The gimbal that a file describes.

    Raises:
        MissionError: its range of pitch is empty.
    """
    lowest, highest = model.pitch_deg
    if not -180 <= lowest < highest <= 180:
        where = document.where("gimbal", "pitch_deg")
        raise MissionError("the gimbal can point nowhere", where, "write e.g. [-90, 30]")
    limits = (math.radians(lowest), math.radians(highest))
    return GimbalSpec(model.component, math.radians(model.rate_dps), limits)


def gimbal_change(event: GimbalEventModel) -> GimbalChange:
    """The change that an event makes to the gimbal."""
    return GimbalChange(event.stuck, bool(event.taken), event.silent)


def check_device_event(
    kind: str, event: Strict, device: Strict | None, document: Document, i: int
) -> None:
    """Refuses an event about an absent device, or one without an effect.

    Raises:
        MissionError: with the place in the file.
    """
    where = document.where("happens", i, kind)
    if device is None:
        hint = f"describe it with the key {kind}"
        raise MissionError(f"there is no {kind} in this scenario", where, hint)
    if not event.model_fields_set:
        hint = f"say {', '.join(type(event).model_fields)}"
        raise MissionError(f"nothing becomes of the {kind}", where, hint)


def check_camera_event(
    event: CameraEventModel, cameras: tuple[CameraModel, ...], document: Document, i: int
) -> None:
    """Refuses an event about an unknown camera, or one without an effect.

    Raises:
        MissionError: with the place in the file.
    """
    where = document.where("happens", i, "camera")
    ids = [each.component for each in cameras]
    if not ids:
        hint = "describe one with the key cameras"
        raise MissionError("there is no camera in this scenario", where, hint)
    if event.component is not None and event.component not in ids:
        where = document.where("happens", i, "camera", "component")
        hint = f"cameras are {', '.join(map(str, ids))}"
        raise MissionError(f"component {event.component} is not a camera", where, hint)
    if event.model_fields_set <= {"component"}:
        hint = "say after_s, busy, fails, full, silent or lost"
        raise MissionError("nothing becomes of the camera", where, hint)
