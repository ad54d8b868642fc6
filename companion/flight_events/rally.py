"""Events about the rally points of the autopilot, before arming."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from companion.flight_events.event import FlightEvent
from companion.flight_events.event_fields import Doc, InText

RallyWords = Annotated[str, Doc("how many, or their names")]


@dataclass(frozen=True, slots=True)
class RallyWritten(FlightEvent):
    """The autopilot has the mission's safe places as rally points."""

    kind = "rally"
    template = "the autopilot's Return may land at {points} from now on, also after the flight"

    points: InText[RallyWords]


@dataclass(frozen=True, slots=True)
class RallyReplaced(FlightEvent):
    """The same, in the place of other rally points."""

    kind = "rally"
    template = "the autopilot's Return may land at {points} from now on, no longer at {before}"

    points: InText[RallyWords]
    before: InText[RallyWords]


@dataclass(frozen=True, slots=True)
class RallyKept(FlightEvent):
    """The rally points that the autopilot has stay."""

    kind = "rally"
    template = "the autopilot keeps {points}"

    points: InText[RallyWords]


@dataclass(frozen=True, slots=True)
class RallyRemoved(FlightEvent):
    """The autopilot has no rally points any more: the mission has no safe places but home."""

    kind = "rally"
    template = "{before} taken away: the autopilot's Return goes home"

    before: InText[RallyWords]


@dataclass(frozen=True, slots=True)
class RallyMissing(FlightEvent):
    """The autopilot was not told of the mission's safe places, or could not be asked."""

    kind = "rally"
    template = "no rally points for the autopilot: {reason}"

    reason: InText[str]


@dataclass(frozen=True, slots=True)
class RallyUnused(FlightEvent):
    """The autopilot has the rally points, and its Return does not go to some of them, or to any."""

    kind = "rally"
    template = "the autopilot's Return does not land at {points}: {reason}"

    points: InText[RallyWords]
    reason: InText[str]
