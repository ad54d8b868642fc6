"""Events about where the mission lies: where it begins, and whether that is certain."""

from __future__ import annotations

from dataclasses import dataclass

from companion.flight_events.event import FlightEvent
from companion.flight_events.event_fields import InText


@dataclass(frozen=True, slots=True)
class FrameLocated(FlightEvent):
    """Where a mission in latitude and longitude begins, and what its metres are reckoned with."""

    kind = "frame"
    template = (
        "{home} is {away_m} m from the origin {latitude_deg}, {longitude_deg} of the autopilot, "
        "and {amsl_m} m above the sea; its positions agree to {residual_m} m"
    )

    home: InText[str]
    latitude_deg: InText[float]
    longitude_deg: InText[float]
    away_m: InText[float]
    amsl_m: InText[float]
    residual_m: InText[float]


@dataclass(frozen=True, slots=True)
class HomeMeasured(FlightEvent):
    """Where the vehicle stands is averaged for some seconds, before the mission can begin."""

    kind = "frame"
    template = (
        "measuring for {for_s:.0f} s where {home} is: "
        "the vehicle's position is good for {accuracy_m} m"
    )

    home: InText[str]
    for_s: InText[float]
    accuracy_m: InText[float]


@dataclass(frozen=True, slots=True)
class HomeRecalled(FlightEvent):
    """A mission in metres begins where another program's flights on this autopilot have begun."""

    kind = "frame"
    template = (
        "{home} and the map lie where they lay in an earlier flight, "
        "{gap_m} m from where the vehicle stands"
    )

    home: InText[str]
    gap_m: InText[float]


@dataclass(frozen=True, slots=True)
class OriginMoved(FlightEvent):
    """The autopilot counts from another origin; the mission stays where it is on the earth."""

    kind = "frame"
    template = "the autopilot's origin has moved by {moved_m} m; flying on in its new frame"

    moved_m: InText[float]


@dataclass(frozen=True, slots=True)
class FrameTrusted(FlightEvent):
    """What the autopilot says of its position agrees again."""

    kind = "frame"
    template = "the position is certain again; going on"


@dataclass(frozen=True, slots=True)
class FrameDoubted(FlightEvent):
    """Where the vehicle is on the earth is not certain: it holds, and the task is frozen."""

    kind = "frame"
    template = "waiting: {reason}"

    reason: InText[str]
