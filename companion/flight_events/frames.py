"""Events about where the mission lies: where it begins, and whether that is certain."""

from __future__ import annotations

from dataclasses import dataclass

from companion.flight_events.event import FlightEvent
from companion.flight_events.event_fields import InText


@dataclass(frozen=True, slots=True)
class FrameLocated(FlightEvent):
    """Where a mission in latitude and longitude begins, and the origin of its metres."""

    kind = "frame"
    template = (
        "{home} is {away_m} m from the autopilot's origin {latitude_deg}, {longitude_deg}, and "
        "{amsl_m} m above sea level; the autopilot's local and global positions agree to "
        "{residual_m} m"
    )

    home: InText[str]
    latitude_deg: InText[float]
    longitude_deg: InText[float]
    away_m: InText[float]
    amsl_m: InText[float]
    residual_m: InText[float]


@dataclass(frozen=True, slots=True)
class HomeMeasured(FlightEvent):
    """The position of the standing vehicle is averaged for some seconds before the mission."""

    kind = "frame"
    template = (
        "measuring for {for_s:.0f} s where {home} is: the vehicle's position is accurate to "
        "{accuracy_m} m"
    )

    home: InText[str]
    for_s: InText[float]
    accuracy_m: InText[float]


@dataclass(frozen=True, slots=True)
class HomeRecalled(FlightEvent):
    """A mission in metres has its origin where earlier flights on this autopilot had it."""

    kind = "frame"
    template = "{home} and the map are where an earlier flight had them, {gap_m} m from the vehicle"

    home: InText[str]
    gap_m: InText[float]


@dataclass(frozen=True, slots=True)
class OriginMoved(FlightEvent):
    """The autopilot's local frame got another origin; the mission keeps its place on the earth."""

    kind = "frame"
    template = (
        "the autopilot's origin has moved by {moved_m} m; the flight continues in the new frame"
    )

    moved_m: InText[float]


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

    reason: InText[str]
