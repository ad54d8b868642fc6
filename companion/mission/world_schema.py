"""The model of what a mission file says of the world: map, limits and places."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from companion.geometry import FAR_M
from companion.mission.keys import given


class StrictModel(BaseModel):
    """A mapping of a mission file; unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


Metres = Annotated[float, Field(ge=-FAR_M, le=FAR_M)]
Span = Annotated[tuple[float, float], Field(description="[from, to], metres from home.")]


class WallEntry(StrictModel):
    """A box on the map that is occupied."""

    east_m: Span
    north_m: Span


class MapEntry(StrictModel):
    """An area with walls, in place of a map file; what lies outside of it is occupied."""

    east_m: Span
    north_m: Span
    cell_m: Annotated[float, Field(ge=0.01, le=10, description="Edge of a cell, metres.")] = 0.1
    walls: Annotated[
        list[WallEntry], Field(description="Boxes: [{east_m: [4, 5], north_m: [0, 6]}, ...].")
    ] = []


class LimitsEntry(StrictModel):
    """What no setpoint may leave."""

    speed_mps: Annotated[float, Field(gt=0, le=20, description="Greatest speed, m/s.")]
    up_m: Annotated[
        tuple[Metres, Metres],
        Field(description="Lowest and highest flight altitude above home, metres: [0.5, 4.0]."),
    ]
    fence: Annotated[
        list[tuple[Metres, Metres]],
        Field(
            min_length=3,
            description="Corners of the area that is never left: [[east, north], ...], metres.",
        ),
    ]
    unusual: Annotated[
        bool,
        Field(
            description="true: a fence beyond 5 km or an altitude beyond 500 m is meant, and not "
            "written in another unit."
        ),
    ] = False


HeadingDeg = Annotated[float, Field(ge=-360, le=360)]


class PlaceEntry(StrictModel):
    """A point, in metres from the home position, with a region around it."""

    east_m: Annotated[Metres, Field(description="Metres east of home.")]
    north_m: Annotated[Metres, Field(description="Metres north of home.")]
    up_m: Annotated[Metres, Field(description="Metres above home.")]
    radius_m: Annotated[
        float, Field(gt=0, le=1000, description="at(place) holds within this distance, metres.")
    ] = 0.6
    heading_deg: Annotated[
        float | None,
        BeforeValidator(given, json_schema_input_type=HeadingDeg),
        Field(
            ge=-360,
            le=360,
            description="Degrees clockwise from north with which the vehicle arrives; without it "
            "any heading will do.",
        ),
    ] = None


class PointEntry(StrictModel):
    """A point on the ground plan; the vehicle need not be able to be there."""

    east_m: Annotated[Metres, Field(description="Metres east of home.")]
    north_m: Annotated[Metres, Field(description="Metres north of home.")]
