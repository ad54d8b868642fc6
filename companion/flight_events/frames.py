"""Events about where the mission lies: where it begins, and whether that is certain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from companion.flight_events.event import FlightEvent
from companion.flight_events.event_fields import Doc, Reason

HomeName = Annotated[str, Doc("the name of the home position")]


@dataclass(frozen=True, slots=True)
class FrameLocated(FlightEvent):
    """Where a mission in latitude and longitude begins, and the origin of its metres."""

    kind = "frame"
    template = (
        "{home} is {away_m} m from the autopilot's origin {latitude_deg}, {longitude_deg}, and "
        "{amsl_m} m above sea level; the autopilot's local and global positions agree to "
        "{residual_m} m"
    )

    home: HomeName
    latitude_deg: Annotated[float, Doc("of the origin")]
    longitude_deg: Annotated[float, Doc("of the origin")]
    away_m: Annotated[float, Doc("from the origin to home")]
    amsl_m: Annotated[float, Doc("of the origin above mean sea level")]
    residual_m: Annotated[float, Doc("by which local and global position differ")]


@dataclass(frozen=True, slots=True)
class HomeMeasured(FlightEvent):
    """The position of the standing vehicle is averaged for some seconds before the mission."""

    kind = "frame"
    template = (
        "measuring for {for_s:.0f} s where {home} is: the vehicle's position is accurate to "
        "{accuracy_m} m"
    )

    home: HomeName
    for_s: Annotated[float, Doc("how long it is measured")]
    accuracy_m: Annotated[float, Doc("standard deviation of the position, by the autopilot")]


@dataclass(frozen=True, slots=True)
class HomeRecalled(FlightEvent):
    """A mission in metres has its origin where earlier flights on this autopilot had it."""

    kind = "frame"
    template = "{home} and the map are where an earlier flight had them, {gap_m} m from the vehicle"

    home: HomeName
    gap_m: Annotated[float, Doc("from where the vehicle stands")]


@dataclass(frozen=True, slots=True)
class OriginMoved(FlightEvent):
    """The autopilot's local frame got another origin; the mission keeps its place on the earth."""

    kind = "frame"
    template = (
        "the autopilot's origin has moved by {moved_m} m; the flight continues in the new frame"
    )

    moved_m: Annotated[float, Doc("by which it has moved")]


@dataclass(frozen=True, slots=True)
class FrameTrusted(FlightEvent):
    """The autopilot's statements about its position agree again."""

    kind = "frame"
    template = "the position is certain again; the flight continues"


@dataclass(frozen=True, slots=True)
class FrameDoubted(FlightEvent):
    """The position on the earth is not certain: the vehicle holds, and the task is frozen."""

    kind = "frame"
    template = "waiting: {reason}"

    reason: Reason
