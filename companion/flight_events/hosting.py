"""Events about what surrounds flights: uploaded missions, the terminal, the run folder."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from companion.flight_events.event import FlightEvent
from companion.flight_events.event_fields import Doc, Reason

PortName = Annotated[str, Doc("the URL of the port, as the command has it")]
IS_REFUSED = Doc("whether the mission may not be flown")


class UploadNews(FlightEvent):
    """News about a mission that came from a ground station.

    Attributes:
        is_refused: it is not flown.
    """

    __slots__ = ()
    kind = "upload"
    is_refused: bool


@dataclass(frozen=True, slots=True)
class UploadChecked(UploadNews):
    """A mission from a ground station was checked during this flight."""

    template = "{verdict}"

    verdict: Annotated[str, Doc("what came of the check, in words")]
    is_refused: Annotated[bool, IS_REFUSED]


@dataclass(frozen=True, slots=True)
class MissionReady(UploadNews):
    """A mission waits for its start."""

    template = "{mission} is ready; MISSION_START flies it"
    is_recorded = False

    mission: Annotated[str, Doc("the name of the mission")]
    is_refused: Annotated[Literal[False], IS_REFUSED] = False


@dataclass(frozen=True, slots=True)
class MissionUnreadable(UploadNews):
    """A mission that was accepted cannot be read after all."""

    template = "the mission cannot be read: {reason}"
    is_recorded = False

    reason: Reason
    is_refused: Annotated[Literal[True], IS_REFUSED] = True


@dataclass(frozen=True, slots=True)
class RunNotBegun(UploadNews):
    """A run that an operator has asked for does not begin."""

    template = "the flight does not begin: {reason}"
    is_recorded = False

    reason: Reason
    is_refused: Annotated[Literal[True], IS_REFUSED] = True


@dataclass(frozen=True, slots=True)
class TerminalHungUp(FlightEvent):
    """The terminal hung up (SIGHUP); the flight continues."""

    kind = "signal"
    template = "the terminal has hung up (SIGHUP); the flight continues"


@dataclass(frozen=True, slots=True)
class DatagramsDropped(FlightEvent):
    """More datagrams arrived on the link than a step takes in, or one that is too long."""

    kind = "link"
    template = "datagrams dropped: {number}; too long, or too many from one sender"

    number: Annotated[int, Doc("dropped since the link was opened")]


@dataclass(frozen=True, slots=True)
class PortLost(FlightEvent):
    """A serial port or a TCP connection was lost; the companion tries to open it each second."""

    kind = "port lost"
    template = "{port} is lost; trying to open it each second: {reason}"

    port: PortName
    reason: Reason


@dataclass(frozen=True, slots=True)
class PortRestored(FlightEvent):
    """Bytes arrive again by a serial port or a TCP connection."""

    kind = "port restored"
    template = "{port} works again"

    port: PortName


@dataclass(frozen=True, slots=True)
class FramesRefused(FlightEvent):
    """Frames were refused on a link with message signing."""

    kind = "link"
    template = "frames refused: {unsigned} unsigned, {forged} with another key, {old} too old"

    unsigned: Annotated[int, Doc("without a signature, since the link was opened")]
    forged: Annotated[int, Doc("with a signature that is wrong")]
    old: Annotated[int, Doc("with a time stamp that is too old")]


@dataclass(frozen=True, slots=True)
class ClockFollowed(FlightEvent):
    """The autopilot's clock runs at another speed, as a simulator's may; the flight follows it."""

    kind = "clock"
    template = (
        "the autopilot's clock runs {speed:g} times as fast as this computer's, like a "
        "simulator's: the flight follows it"
    )

    speed: Annotated[float, Doc("seconds of the flight for each second of this computer")]


@dataclass(frozen=True, slots=True)
class RecordingFailed(FlightEvent):
    """The run folder cannot be written any more; the flight goes on."""

    kind = "record"
    template = "the run folder cannot be written; the flight continues: {reason}"
    is_recorded = False

    reason: Reason
