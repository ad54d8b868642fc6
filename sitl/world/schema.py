"""Which keys may a scenario file have, and which values?

The pydantic models of `NAME.sim.yaml`; scenario.py turns them into the types that the simulator
works with. Unknown keys are refused. Descriptions serve as hints in error messages.
"""

from __future__ import annotations

from typing import Annotated, Literal

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


class SeenModel(_Strict):
    """The circle in which the target is seen."""

    east_m: float
    north_m: float
    radius_m: Annotated[float, Field(gt=0)]
    visit: Annotated[
        int, Field(ge=1, description="the vehicle's n-th visit to the circle, from 1")
    ] = 1


class TargetModel(_Strict):
    """The target detector."""

    component: Annotated[
        int, Field(ge=2, le=255, description="MAVLink component id of the detector")
    ] = 26
    seen: SeenModel


class SiteModel(_Strict):
    """What the payload answers inside a circle."""

    east_m: float
    north_m: float
    radius_m: Annotated[float, Field(gt=0)]
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
