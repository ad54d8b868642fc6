"""Events about the rally points of the autopilot, before arming."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from companion.flight_events.event import FlightEvent
from companion.flight_events.event_fields import Doc, Reason

RallyWords = Annotated[str, Doc("how many rally points, or their names")]
Before = Annotated[str, Doc("the same of what was there before")]


@dataclass(frozen=True, slots=True)
class RallyWritten(FlightEvent):
    """The autopilot has the mission's safe places as rally points."""

    kind = "rally"
    template = "the autopilot's Return may land at {points} from now on, also after the flight"

    points: RallyWords


@dataclass(frozen=True, slots=True)
class RallyReplaced(FlightEvent):
    """The same; they replaced other rally points."""

    kind = "rally"
    template = "the autopilot's Return may land at {points} from now on, no longer at {before}"

    points: RallyWords
    before: Before


@dataclass(frozen=True, slots=True)
class RallyKept(FlightEvent):
    """The autopilot keeps the rally points that it has."""

    kind = "rally"
    template = "the autopilot keeps {points}"

    points: RallyWords


@dataclass(frozen=True, slots=True)
class RallyRemoved(FlightEvent):
    """The autopilot has no rally points any more: home is the mission's only safe place."""

    kind = "rally"
    template = "{before} removed: the autopilot's Return goes home"

    before: Before


@dataclass(frozen=True, slots=True)
class RallyMissing(FlightEvent):
    """The autopilot did not get the mission's safe places, or could not be asked."""

    kind = "rally"
    template = "no rally points for the autopilot: {reason}"

    reason: Reason


@dataclass(frozen=True, slots=True)
class RallyUnused(FlightEvent):
    """The autopilot has the rally points, but its Return goes to none or only some of them."""

    kind = "rally"
    template = "the autopilot's Return does not land at {points}: {reason}"

    points: RallyWords
    reason: Reason
