"""Vehicle profiles in files: `vehicles/NAME.yaml` beside the missions and scenarios that name them.

    version: 1
    radius_m: 0.35
    ...

A profile has all keys, except those for response and turning, which may be left out and default to
the default profile. A mission or scenario names a profile (`vehicle: NAME`) and may override single
values (`vehicle: {profile: NAME, radius_m: 0.4}`). Without the key `vehicle`, the default profile
applies; it is built in, because its file may not be there.

A door: it opens the file of the profile.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field
from pydantic.json_schema import SkipJsonSchema
from pydantic_core import PydanticCustomError

from companion.documents import Document, did_you_mean, validate
from companion.documents.sources import read_source
from companion.errors import MissionError
from companion.vehicle_profile import DEFAULT_VEHICLE, LEAST_MPS, VehicleProfile

FOLDER = "vehicles"

T = TypeVar("T")


def _given(value: Any) -> Any:
    if value is None:
        raise PydanticCustomError("empty", "has no value; write one, or remove the key")
    return value


Override = Annotated[T | SkipJsonSchema[None], BeforeValidator(_given)]
"""A value that may be left out, but not be empty."""

ProfileName = Annotated[
    str,
    Field(
        pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]*$",
        max_length=40,
        description="Name of a vehicle profile: vehicles/NAME.yaml beside this file.",
    ),
]


def _positive(description: str, most: float = 100) -> Any:
    return Field(gt=0, le=most, description=description)


def _speed(description: str) -> Any:
    return Field(ge=LEAST_MPS, le=100, description=description)


def _not_negative(description: str) -> Any:
    return Field(ge=0, le=100, description=description)


Radius = Annotated[float, _positive("From the centre to the farthest point of a rotor, m.")]
Margin = Annotated[float, _not_negative("Distance that stays free beside the vehicle, m.")]
Deviation = Annotated[
    float, _not_negative("How much nearer than its route the vehicle may come to an obstacle, m.")
]
Speed = Annotated[float, _speed("Greatest speed, m/s; a mission may allow less.")]
Climb = Annotated[float, _speed("Greatest vertical speed upwards, m/s.")]
Descent = Annotated[float, _speed("Greatest vertical speed downwards, m/s.")]
Acceleration = Annotated[float, _positive("Acceleration of trajectories and plans, m/s2.")]
Braking = Annotated[
    float, _positive("Deceleration before an obstacle if there is no way around it, m/s2.")
]
MaxAcceleration = Annotated[
    float, _positive("Greatest acceleration that the position controller asks for, m/s2.")
]
Jerk = Annotated[float, _positive("Jerk of trajectories, m/s3.", most=1000)]
Response = Annotated[
    float,
    Field(
        ge=0, le=2, description="Delay from the command of an acceleration to the acceleration, s."
    ),
]
FeedForward = Annotated[
    float,
    Field(ge=0, le=2, description="Share of a trajectory's acceleration that setpoints contain."),
]
YawRate = Annotated[
    float,
    _positive(
        "Greatest rate at which the vehicle is turned, rad/s: 1.5 is 86 degrees a second.", most=10
    ),
]
Carrot = Annotated[float, _positive("Greatest distance of a setpoint from the vehicle, m.")]


class VehicleEntry(BaseModel):
    """A vehicle profile, and the values that override its own."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    profile: ProfileName = DEFAULT_VEHICLE
    radius_m: Override[Radius] = None
    margin_m: Override[Margin] = None
    deviation_m: Override[Deviation] = None
    speed_mps: Override[Speed] = None
    climb_mps: Override[Climb] = None
    descent_mps: Override[Descent] = None
    acceleration_mps2: Override[Acceleration] = None
    braking_mps2: Override[Braking] = None
    max_acceleration_mps2: Override[MaxAcceleration] = None
    jerk_mps3: Override[Jerk] = None
    response_s: Override[Response] = None
    feed_forward: Override[FeedForward] = None
    yaw_rate_radps: Override[YawRate] = None
    carrot_m: Override[Carrot] = None


class VehicleFile(BaseModel):
    """A vehicle profile: the vehicle in numbers."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, title="Vehicle")

    version: Annotated[Literal[1], Field(description="Version of this format: 1.")]
    radius_m: Radius
    margin_m: Margin
    deviation_m: Deviation
    speed_mps: Speed
    climb_mps: Climb
    descent_mps: Descent
    acceleration_mps2: Acceleration
    braking_mps2: Braking
    max_acceleration_mps2: MaxAcceleration
    jerk_mps3: Jerk
    response_s: Response = VehicleProfile().response_s
    feed_forward: FeedForward = VehicleProfile().feed_forward
    yaw_rate_radps: YawRate = VehicleProfile().yaw_rate_radps
    carrot_m: Carrot


def _by_name(value: Any) -> Any:
    return {"profile": value} if isinstance(value, str) else value


VehicleKey = Annotated[
    VehicleEntry,
    BeforeValidator(_by_name, json_schema_input_type=ProfileName | VehicleEntry),
    Field(
        description="The vehicle: NAME of a profile, vehicles/NAME.yaml beside this file; or "
        "{profile: NAME, radius_m: 0.4} with the values that differ from it.",
        json_schema_extra={"default": DEFAULT_VEHICLE},
    ),
]
"""The key `vehicle` of a mission or scenario."""


def read_vehicle(entry: VehicleEntry, folder: Path, document: Document) -> VehicleProfile:
    """The profile that a mission or scenario names.

    Args:
        entry: the value of its key `vehicle`.
        folder: to which the profile's file is relative.
        document: the mission or scenario, to locate a mistake.

    Raises:
        MissionError: the profile has no file, or one with a mistake.
    """
    overrides = entry.model_dump(exclude_unset=True, exclude={"profile"})
    path = profile_path(entry.profile, folder)
    profile = read_profile(path) if path.is_file() else _built_in(entry.profile, folder, document)
    return replace(profile, **overrides)


def read_profile(path: Path) -> VehicleProfile:
    """The profile in a file.

    Raises:
        MissionError: it cannot be read, or has a mistake.
    """
    file, _ = validate(read_source(path, "vehicle").content, str(path), VehicleFile)
    return VehicleProfile(name=path.stem, **file.model_dump(exclude={"version"}))


def profile_path(name: str, folder: Path) -> Path:
    """The file of a profile, which need not exist."""
    return folder / FOLDER / f"{name}.yaml"


def json_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a vehicle profile."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **VehicleFile.model_json_schema(),
    }


def _built_in(name: str, folder: Path, document: Document) -> VehicleProfile:
    if name == DEFAULT_VEHICLE:
        return VehicleProfile()
    known = {DEFAULT_VEHICLE, *(path.stem for path in sorted((folder / FOLDER).glob("*.yaml")))}
    listed = ", ".join(sorted(known))
    raise MissionError(
        f"there is no vehicle profile {name}",
        document.where("vehicle"),
        f"{profile_path(name, folder)} does not exist; known are {listed}. "
        f"{did_you_mean(name, sorted(known))}".rstrip(),
    )
