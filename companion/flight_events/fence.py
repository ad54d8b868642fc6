"""Events about the fence of the autopilot."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Annotated

from companion.flight_events.event import FlightEvent
from companion.flight_events.event_fields import Doc, Reason
from companion.geometry import NorthEast

FenceWords = Annotated[str, Doc("how many points and areas the fence has")]
Before = Annotated[str, Doc("the same of what was there before")]
Polygon = tuple[NorthEast, ...]


@dataclass(frozen=True, slots=True)
class FenceWritten(FlightEvent):
    """The autopilot has the mission's fence, and it is in force."""

    kind = "fence"
    template = "the autopilot has the mission's fence ({fence}), and keeps it after the flight"

    fence: FenceWords


@dataclass(frozen=True, slots=True)
class FenceReplaced(FlightEvent):
    """The same; it replaced another fence."""

    kind = "fence"
    template = "the mission's fence ({fence}) has replaced the autopilot's ({before})"

    fence: FenceWords
    before: Before


@dataclass(frozen=True, slots=True)
class FenceKept(FlightEvent):
    """The autopilot keeps its own fence; all places lie in it, and the flight stays in it."""

    kind = "fence"
    template = "the autopilot keeps its fence ({fence})"

    fence: FenceWords
    within: Annotated[
        tuple[Polygon, ...],
        Doc(
            "polygons that are not the mission's; the flight stays in each: their corners, metres "
            "north and east of home"
        ),
    ] = ()
    keep_out: Annotated[
        tuple[Polygon, ...],
        Doc("the same, but the flight stays out; circles are polygons on the safe side"),
    ] = ()


@dataclass(frozen=True, slots=True)
class FenceMissing(FlightEvent):
    """The autopilot has no fence; only the companion's gate keeps the vehicle inside."""

    kind = "fence"
    template = "no fence in the autopilot: {reason}"

    reason: Reason


@dataclass(frozen=True, slots=True)
class FenceNear(FlightEvent):
    """The vehicle stands nearer to an edge of the fence than the error of its position."""

    kind = "fence"
    template = (
        "the fence is nearer than the possible error of the position, {error_m:.1f} m: the "
        "autopilot may end the flight during the climb"
    )

    error_m: Annotated[float, Doc("the possible error of the position, rounded to 0.1 m")]


class FenceChange(Enum):
    """What somebody else has done to the autopilot's fence."""

    REPLACED = "replaced"
    REMOVED = "removed"


@dataclass(frozen=True, slots=True)
class FenceChanged(FlightEvent):
    """Somebody changed the autopilot's fence after it was checked.

    The companion reads no fence in the air, so it does not know the new one: the flight keeps to
    the limits it had, and the autopilot may stop it.
    """

    kind = "fence"
    template = "somebody has {change} the autopilot's fence; the flight keeps to the limits it had"

    change: Annotated[FenceChange, Doc("what was done to it")]
