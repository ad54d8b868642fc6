"""Events about the word of the flight: its positions, and what they violate."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated

from companion.flight_events.event import FlightEvent
from companion.flight_events.event_fields import Doc

Facts = Annotated[
    tuple[str, ...],
    Doc("a list of the facts that held, with those beliefs that the task mentions"),
]


@dataclass(frozen=True, slots=True)
class PositionLeft(FlightEvent):
    """A position of the word was left."""

    kind = "position"
    template = "position {number}: {listed}"
    is_told = False

    number: Annotated[int, Doc("of the position; 0 is the start")]
    facts: Facts
    risen: Annotated[
        tuple[str, ...],
        Doc("a list of the events among the facts that were true before, but not any more"),
    ]
    reached_s: Annotated[float, Doc("seconds since the run began, when the position was appended")]
    withdrawn: Annotated[tuple[str, ...], Doc("a list of the beliefs that are not held")]
    restarted: Annotated[
        tuple[str, ...], Doc("a list of the lines of the task that begin anew with this position")
    ]
    for_ever: Annotated[
        bool,
        Doc("whether the vehicle rests here, so that all later positions are the same"),
    ]
    dropped: Annotated[
        tuple[str, ...], Doc("a list of the lines of the task that the plan did not keep there")
    ] = ()

    @property
    def listed(self) -> str:
        """The facts in one line."""
        return ", ".join(self.facts)


def since(event: FlightEvent, start_s: float) -> FlightEvent:
    """An event whose own time, if it has one, counts from the beginning of a run."""
    if not isinstance(event, PositionLeft):
        return event
    return replace(event, reached_s=round(max(0.0, event.reached_s - start_s), 3))


@dataclass(frozen=True, slots=True)
class ConjunctViolated(FlightEvent):
    """From this position on, a conjunct cannot hold any more."""

    kind = "violation"
    template = "{conjunct} violated at position {position}: {formula}"

    conjunct: Annotated[str, Doc("the name of the line of the task that is violated")]
    formula: Annotated[str, Doc("what is violated")]
    position: Annotated[int, Doc("the number of the position that violates it")]
    facts: Facts
    optional: Annotated[bool, Doc("whether the line may be dropped and the task continues")] = False


@dataclass(frozen=True, slots=True)
class ViolatedBefore(FlightEvent):
    """A resumed flight had violated its task before the companion was away."""

    kind = "violated before"
    template = "violated before the interruption: {listed}"

    lines: Annotated[
        tuple[str, ...], Doc("a list of the lines of the task that no continuation can satisfy")
    ]

    @property
    def listed(self) -> str:
        """The lines in words."""
        return ", ".join(self.lines)
