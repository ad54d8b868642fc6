"""Calls of installed functions and their answers, as values and as lines of JSON.

A mission makes a call. A request adds what the function may know when it begins. An answer is what
the function's process has said since it was last asked.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, TypeAlias

from companion.outcomes import Failed
from companion.skills.authoring import (
    FunctionKind,
    KnownPlace,
    KnownVehicle,
    WaypointEnu,
    why_not_carried,
)
from companion.skills.lines import Malformed

Value: TypeAlias = "str | float | int | bool"
MAX_TEXT = 200
"""Most characters of a text that are passed on."""
MAX_WAYPOINTS = 48
"""Most waypoints of one suggester."""


@dataclass(frozen=True, slots=True)
class Function:
    """An installed function, by the name of its entry point."""

    kind: FunctionKind
    name: str


@dataclass(frozen=True, slots=True)
class Call:
    """A function with its arguments.

    >>> Call(Function(FunctionKind.SKILL, "weigh"), ("A",), (("limit_kg", 2.5),)).text
    'python(weigh, A, limit_kg=2.5)'
    """

    function: Function
    arguments: tuple[Value, ...] = ()
    keywords: tuple[tuple[str, Value], ...] = ()

    @property
    def text(self) -> str:
        """The call as a mission writes it."""
        named = (f"{name}={value}" for name, value in self.keywords)
        return f"python({', '.join([self.function.name, *map(str, self.arguments), *named])})"


@dataclass(frozen=True, slots=True)
class CallRequest:
    """A call that is about to begin.

    Attributes:
        places: the places that the function may know.
        place: the one of them for a suggester or a test; "" for a skill.
        waypoints: the ones to test.
    """

    call: Call
    places: tuple[KnownPlace, ...] = ()
    vehicle: KnownVehicle | None = None
    place: str = ""
    waypoints: tuple[WaypointEnu, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """The content of the message to the function's process."""
        return {
            "arguments": list(self.call.arguments),
            "keywords": dict(self.call.keywords),
            "places": [asdict(place) for place in self.places],
            "vehicle": self.vehicle and asdict(self.vehicle),
            "place": self.place,
            "waypoints": [list(waypoint) for waypoint in self.waypoints],
        }


@dataclass(frozen=True, slots=True)
class Progressed:
    """Progress.

    Attributes:
        share: from 0 to 1; None if unknown.
    """

    share: float | None
    text: str


@dataclass(frozen=True, slots=True)
class CommandAsked:
    """The function asks for a command to a payload, and waits for the reply."""

    component: str | int
    command: str
    parameters: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Returned:
    """The function has returned.

    Attributes:
        waypoints: those that a suggester proposes.
        verdicts: for each waypoint, whether it passes a test.
    """

    waypoints: tuple[WaypointEnu, ...] = ()
    verdicts: tuple[bool, ...] = ()


Answer: TypeAlias = "Progressed | CommandAsked | Returned | Failed"


def answer_of(message: Mapping[str, Any]) -> Answer:
    """The answer in a message from a function's process.

    >>> answer_of({"is": "progress", "share": 0.5, "text": "half"})
    Progressed(share=0.5, text='half')

    Raises:
        Malformed: the message is no answer.
    """
    try:
        match message["is"]:
            case "progress":
                share = message["share"]
                share = None if share is None else min(1.0, max(0.0, float(share)))
                return Progressed(share, _text(message["text"]))
            case "command":
                component = message["component"]
                if not isinstance(component, str | int):
                    raise Malformed
                parameters = tuple(float(each) for each in message["parameters"])
                if why_not_carried(parameters):
                    raise Malformed
                return CommandAsked(component, _text(message["command"]), parameters)
            case "returned":
                verdicts = tuple(each is True for each in message["verdicts"])
                return Returned(_waypoints(message["waypoints"]), verdicts)
            case "failed":
                return Failed(_text(message["text"]))
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError):
        pass
    raise Malformed


def _text(written: Any) -> str:
    """One line of limited length that can be encoded."""
    return " ".join(str(written).encode(errors="replace").decode().split())[:MAX_TEXT]


def _waypoints(written: Any) -> tuple[WaypointEnu, ...]:
    waypoints = []
    for east_m, north_m, up_m in written[:MAX_WAYPOINTS]:
        waypoint = WaypointEnu(float(east_m), float(north_m), None if up_m is None else float(up_m))
        if not all(metres is None or math.isfinite(metres) for metres in waypoint):
            raise Malformed
        waypoints.append(waypoint)
    return tuple(waypoints)
