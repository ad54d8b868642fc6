"""The model of what a mission file says of the world: limits, places, and where to land."""

from __future__ import annotations

from typing import Annotated

from pydantic import BeforeValidator, ConfigDict, Field, JsonValue

from companion.drawn_maps import Corner, DrawnModel, Metres
from companion.mission.keys import Name, Text, given
from companion.vehicle_profile import LEAST_MPS


class LimitsEntry(DrawnModel):
    """Limits that all setpoints keep."""

    speed_mps: Annotated[float, Field(ge=LEAST_MPS, le=20, description="Greatest speed, m/s.")]
    up_m: Annotated[
        tuple[Metres, Metres],
        Field(description="Lowest and highest flight altitude above home, metres: [0.5, 4.0]."),
    ]
    fence: Annotated[
        list[Corner] | None,
        BeforeValidator(given, json_schema_input_type=list[Corner]),
        Field(
            min_length=3,
            description="Corners of the area that the vehicle never leaves: [[east, north], "
            "...], metres; with frame: wgs84 [[lat, lon], ...], degrees. Without this "
            "key, the area of the map.",
        ),
    ] = None
    keep_out: Annotated[
        dict[Name, list[Corner]],
        Field(
            description="Areas that the vehicle never enters, by name: {pond: [[east, north], "
            "...]}; corners as those of the fence."
        ),
    ] = {}
    unusual: Annotated[
        bool,
        Field(
            description="true: a fence beyond 5 km or an altitude beyond 500 m is intended, not "
            "a mistake of units."
        ),
    ] = False
    beyond_sight: Annotated[
        bool,
        Field(
            description="true: the map shows all obstacles. A vehicle with a range finder may "
            "then fly so fast that it cannot stop within the range finder's sight."
        ),
    ] = False


Latitude = Annotated[float, Field(ge=-90, le=90)]
Longitude = Annotated[float, Field(ge=-180, le=180)]
AboveSea = Annotated[float, Field(ge=-500, le=9000)]
Radius = Annotated[float, Field(gt=0, le=1000)]
HeadingDeg = Annotated[float, Field(ge=-360, le=360)]


def _one_of(*required: list[JsonValue]) -> ConfigDict:
    """A mapping that has all keys of one of the lists."""
    return ConfigDict(json_schema_extra={"oneOf": [{"required": keys} for keys in required]})


class PointEntry(DrawnModel):
    """A point on the ground plan; the vehicle need not be able to be there.

    Which keys it has follows from the mission's frame (coordinates.py).
    """

    model_config = _one_of(["east_m", "north_m"], ["lat_deg", "lon_deg"])

    east_m: Annotated[
        Metres | None,
        BeforeValidator(given, json_schema_input_type=Metres),
        Field(description="Metres east of home."),
    ] = None
    north_m: Annotated[
        Metres | None,
        BeforeValidator(given, json_schema_input_type=Metres),
        Field(description="Metres north of home."),
    ] = None
    lat_deg: Annotated[
        Latitude | None,
        BeforeValidator(given, json_schema_input_type=Latitude),
        Field(description="Degrees north (WGS 84), with frame: wgs84."),
    ] = None
    lon_deg: Annotated[
        Longitude | None,
        BeforeValidator(given, json_schema_input_type=Longitude),
        Field(description="Degrees east (WGS 84), with frame: wgs84."),
    ] = None

    @property
    def in_words(self) -> str:
        """The point in words, for messages."""
        if self.lat_deg is not None and self.lon_deg is not None:
            return f"latitude {self.lat_deg:g}, longitude {self.lon_deg:g}"
        return f"east {self.east_m:g} m, north {self.north_m:g} m"


class MarkerEntry(DrawnModel):
    """A marker on which the vehicle can land (LANDING_TARGET)."""

    component: Annotated[
        Name, Field(description="The detector that sees the marker: a name of `components`.")
    ]
    number: Annotated[
        int,
        Field(
            ge=0,
            le=255,
            description="The number that is read off the marker: its target_num; 0 by default.",
        ),
    ] = 0


class LookAtEntry(PointEntry):
    """A point to look at."""

    up_m: Annotated[Metres, Field(description="Metres above home, for a gimbal.")] = 0.0


class PlaceEntry(PointEntry):
    """A point with a region around it: in metres from home, or on the earth."""

    model_config = _one_of(
        ["east_m", "north_m", "up_m"],
        ["lat_deg", "lon_deg", "up_m"],
        ["lat_deg", "lon_deg", "amsl_m"],
    )

    up_m: Annotated[
        Metres | None,
        BeforeValidator(given, json_schema_input_type=Metres),
        Field(description="Metres above home."),
    ] = None
    amsl_m: Annotated[
        AboveSea | None,
        BeforeValidator(given, json_schema_input_type=AboveSea),
        Field(description="Metres above mean sea level, instead of up_m, with frame: wgs84."),
    ] = None
    radius_m: Annotated[
        Radius | None,
        BeforeValidator(given, json_schema_input_type=Radius),
        Field(description="at(place) holds within this distance, metres; 0.6 by default."),
    ] = None
    corners: Annotated[
        list[Corner] | None,
        BeforeValidator(given, json_schema_input_type=list[Corner]),
        Field(
            description="Instead of radius_m: at(place) holds over this polygon, at any height; "
            "corners as those of the fence."
        ),
    ] = None
    heading_deg: Annotated[
        float | None,
        BeforeValidator(given, json_schema_input_type=HeadingDeg),
        Field(
            ge=-360,
            le=360,
            description="Heading with which the vehicle arrives, degrees clockwise from north; "
            "without this key, any heading.",
        ),
    ] = None
    marker: Annotated[
        MarkerEntry | None,
        BeforeValidator(given, json_schema_input_type=MarkerEntry),
        Field(
            description="For land_on: a marker below the place, within its region, on the "
            "ground or on a wall with up_m: {component: NAME, number: 3}."
        ),
    ] = None
    suggesters: Annotated[
        list[Text],
        Field(
            max_length=8,
            description="Installed functions that propose other points of the region if the "
            "vehicle cannot fly to the point itself: [python(NAME)], with arguments.",
        ),
    ] = []
    tests: Annotated[
        list[Text],
        Field(
            max_length=8,
            description="Installed functions that say whether the vehicle may fly to a point of "
            "the region: [python(NAME)], with arguments.",
        ),
    ] = []
    found_by: Annotated[
        Name | None,
        BeforeValidator(given, json_schema_input_type=Name),
        Field(
            description="The event that becomes true when another program has reported where in "
            "this region the place is. Until then, nothing flies there."
        ),
    ] = None


class LandAtEntry(DrawnModel):
    """Places to land at when no plan exists."""

    land_at: Annotated[
        list[Name],
        Field(
            min_length=1,
            max_length=32,
            description="Places: the vehicle lands at the one that it reaches soonest, e.g. "
            "[Home, North, South].",
        ),
    ]
