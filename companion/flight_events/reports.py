"""What is told of programs that report events of a mission, such as detectors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from companion.flight_events.event import FlightEvent
from companion.flight_events.event_fields import Doc, Reason

EventName = Annotated[str, Doc("an event of the mission")]
SignalName = Annotated[str, Doc("the signal in the event's condition")]


@dataclass(frozen=True, slots=True)
class SignalSilent(FlightEvent):
    """The signal of an event was not heard for a time; the event keeps its value."""

    kind = "silent"
    template = "{event} keeps its last value: {signal} is silent"

    event: EventName
    signal: SignalName


@dataclass(frozen=True, slots=True)
class SignalHeard(FlightEvent):
    """The signal of an event is heard again."""

    kind = "heard"
    template = "{event} is up to date again: {signal} is heard"

    event: EventName
    signal: SignalName


@dataclass(frozen=True, slots=True)
class ReportRefused(FlightEvent):
    """A report of another program cannot be used."""

    kind = "report"
    template = "reports refused: {number}; the last one: {reason}"

    reason: Reason
    number: Annotated[int, Doc("refused since the flight began")]


@dataclass(frozen=True, slots=True)
class ReportUnknown(FlightEvent):
    """Another program reports a name that the mission does not use; told once for each name."""

    kind = "report"
    template = "a program reports {name}, which the mission does not use; it uses {listed}"

    name: Annotated[str, Doc("that is reported")]
    known: Annotated[tuple[str, ...], Doc("a list of the names that the mission uses")]

    @property
    def listed(self) -> str:
        """The names that the mission uses, in words."""
        return ", ".join(self.known) or "none"


@dataclass(frozen=True, slots=True)
class SignalOfAnother(FlightEvent):
    """The signal of an event came from another system than the vehicle; told once for each."""

    kind = "report"
    template = "{signal} of system {system} is ignored: the vehicle is system {vehicle}"

    signal: SignalName
    system: Annotated[int, Doc("the system id of the sender")]
    vehicle: Annotated[int, Doc("the system id of the vehicle")]
