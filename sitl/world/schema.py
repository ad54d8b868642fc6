"""Which keys may a scenario file have, and which values?

The pydantic models of `NAME.sim.yaml`; scenario.py turns them into the types that the simulator
works with. Unknown keys are refused. Descriptions serve as hints in error messages.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

ResultName = Literal["ACCEPTED", "TEMPORARILY_REJECTED", "DENIED", "FAILED"]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class StartModel(_Strict):
    """Where the vehicle stands at first."""

    east_m: float = 0.0
    north_m: float = 0.0
    heading_deg: Annotated[float, Field(description="clockwise from north")] = 0.0


class HomeModel(_Strict):
    """Where the local frame's origin lies on the earth."""

    latitude_deg: Annotated[float, Field(ge=-90, le=90)]
    longitude_deg: Annotated[float, Field(ge=-180, le=180)]
    altitude_m: Annotated[float, Field(description="above mean sea level")] = 488.0


class WindModel(_Strict):
    """Where the air moves to, and how rough it is."""

    east_mps: Annotated[float, Field(ge=-30, le=30)] = 0.0
    north_mps: Annotated[float, Field(ge=-30, le=30)] = 0.0
    turbulence_mps: Annotated[float, Field(ge=0, le=10)] = 0.0


class BatteryModel(_Strict):
    """The battery at the start."""

    charge: Annotated[float, Field(ge=0, le=1, description="state of charge, 0 to 1")] = 1.0
    drains: Annotated[
        Literal["armed", "always"], Field(description="when; in PX4's simulator while armed")
    ] = "armed"


class CircleModel(_Strict):
    """A circle on the ground."""

    east_m: float
    north_m: float
    radius_m: Annotated[float, Field(gt=0)]


class SeenModel(CircleModel):
    """A visit of the vehicle to a circle."""

    visit: Annotated[
        int, Field(ge=1, description="the vehicle's n-th visit to the circle, from 1")
    ] = 1


class TargetModel(_Strict):
    """The target detector."""

    component: Annotated[
        int, Field(ge=2, le=255, description="MAVLink component id of the detector")
    ] = 26
    seen: Annotated[SeenModel | None, Field(description="when the target is seen first")] = None


class SiteModel(CircleModel):
    """What the payload answers inside a circle."""

    result: ResultName
    after_s: Annotated[float, Field(ge=0, description="seconds until the final answer")] = 1.0


class PayloadModel(_Strict):
    """The payload."""

    component: Annotated[
        int, Field(ge=2, le=255, description="MAVLink component id of the payload")
    ] = 25
    command: Annotated[str, Field(description="a MAVLink command by name, such as MAV_CMD_USER_1")]
    answers: tuple[SiteModel, ...] = ()
    otherwise: ResultName = "DENIED"


class LidarModel(_Strict):
    """The lidar."""

    component: Annotated[
        int, Field(ge=2, le=255, description="MAVLink component id of the lidar")
    ] = 196
    range_m: Annotated[float, Field(gt=0, le=600)] = 12.0
    noise_m: Annotated[float, Field(ge=0, description="deviation of each distance")] = 0.0


class BoxModel(_Strict):
    """A box with sides to the east and to the north."""

    east_m: Annotated[tuple[float, float], Field(description="[from, to]")]
    north_m: Annotated[tuple[float, float], Field(description="[from, to]")]


class ObstacleModel(_Strict):
    """Something in the way that the mission's map does not show: a circle or a box."""

    name: Annotated[str, Field(min_length=1)]
    circle: CircleModel | None = None
    box: BoxModel | None = None
    present: Annotated[bool, Field(description="whether it is there at the start")] = True


class PadModel(CircleModel):
    """A charging pad: on it, landed and disarmed, the battery charges."""

    current_a: Annotated[float, Field(gt=0, le=100)] = 5.0


class PayloadEventModel(_Strict):
    """What the payload answers from now on."""

    result: ResultName = "ACCEPTED"
    after_s: Annotated[float, Field(ge=0, description="seconds until the final answer")] = 1.0
    silent: Annotated[bool, Field(description="nothing is answered at all")] = False
    progress: Annotated[bool, Field(description="tell the progress each second")] = False


class WindEventModel(_Strict):
    """Where the air moves to from now on."""

    east_mps: Annotated[float, Field(ge=-30, le=30)] = 0.0
    north_mps: Annotated[float, Field(ge=-30, le=30)] = 0.0


class ObstacleEventModel(_Strict):
    """An obstacle appears or disappears."""

    name: str
    present: bool


class BatteryEventModel(_Strict):
    """The battery's charge jumps."""

    charge: Annotated[float, Field(ge=0, le=1, description="state of charge, 0 to 1")]


class GpsEventModel(_Strict):
    """How good GPS is from now on; what is left out stays."""

    lost: bool | None = None
    noise_m: Annotated[float | None, Field(ge=0, description="deviation, metres")] = None


class ArmingEventModel(_Strict):
    """Whether the autopilot lets itself be armed."""

    refused: Annotated[str | None, Field(min_length=1, description="why, as it is told")] = None
    allowed: Literal[True] | None = None


class HappeningModel(_Strict):
    """One trigger (at_s, place or command) and what happens then, once."""

    at_s: Annotated[float | None, Field(ge=0, description="simulated seconds")] = None
    place: SeenModel | None = None
    command: Annotated[str | None, Field(description="MAV_CMD_... that arrives on board")] = None
    nth: Annotated[int | None, Field(ge=1, description="the n-th such command")] = None
    component: Annotated[int | None, Field(ge=1, le=255, description="to whom")] = None
    after_s: Annotated[float, Field(ge=0, description="seconds after the trigger")] = 0.0
    target: Literal["seen", "lost"] | None = None
    payload: PayloadEventModel | None = None
    wind: WindEventModel | None = None
    obstacle: ObstacleEventModel | None = None
    battery: BatteryEventModel | None = None
    gps: GpsEventModel | None = None
    arming: ArmingEventModel | None = None


class ScenarioModel(_Strict):
    """The whole file."""

    version: Literal[1]
    map: Annotated[
        str | None, Field(description="ROS map_server YAML file, relative to this file")
    ] = None
    start: StartModel = StartModel()
    home: HomeModel | None = None
    wind: WindModel = WindModel()
    battery: BatteryModel = BatteryModel()
    parameters: dict[str, float] = {}
    target: TargetModel | None = None
    payload: PayloadModel | None = None
    lidar: Annotated[
        LidarModel | None, Field(description="there by default where there is a map")
    ] = None
    obstacles: tuple[ObstacleModel, ...] = ()
    pads: Annotated[tuple[PadModel, ...], Field(description="charging pads")] = ()
    happens: Annotated[tuple[HappeningModel, ...], Field(description="what happens when")] = ()


def json_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a scenario file."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **ScenarioModel.model_json_schema(),
    }
