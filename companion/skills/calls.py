"""Calls of installed functions, and what comes back, as values; and both as lines of JSON.

A call is made by the mission, a request adds what the function may know when it begins, and an
answer is what the function's process has said since it was last asked.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, TypeAlias

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
"""Characters of a text that are handed on."""
MAX_WAYPOINTS = 48
"""Of one suggester."""


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
        """As a mission writes it."""
        named = (f"{name}={value}" for name, value in self.keywords)
        return f"python({', '.join([self.function.name, *map(str, self.arguments), *named])})"


@dataclass(frozen=True, slots=True)
class CallRequest:
    """A call that is to begin.

    Attributes:
        places: that the function may know.
        place: which of them a suggester or a test is asked about; "" for a skill.
        waypoints: that a test is asked about.
    """

    call: Call
    places: tuple[KnownPlace, ...] = ()
    vehicle: KnownVehicle | None = None
    place: str = ""
    waypoints: tuple[WaypointEnu, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """What the function's process needs of it."""
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
    """How far it has come.

    Attributes:
        share: from 0 to 1; None if it does not say.
    """

    share: float | None
    text: str


@dataclass(frozen=True, slots=True)
class CommandAsked:
    """It asks for a payload's command, and waits for the reply."""

    component: str | int
    command: str
    parameters: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Returned:
    """It has ended well.

    Attributes:
        waypoints: those that a suggester proposes.
        verdicts: whether each of the waypoints passes a test.
    """

    waypoints: tuple[WaypointEnu, ...] = ()
    verdicts: tuple[bool, ...] = ()


@dataclass(frozen=True, slots=True)
class NotDone:
    """It has failed, for a reason in words."""

    reason: str


Answer: TypeAlias = "Progressed | CommandAsked | Returned | NotDone"


def answer_of(message: Mapping[str, Any]) -> Answer:
    """The answer in a message of a function's process.

    >>> answer_of({"is": "progress", "share": 0.5, "text": "half"})
    Progressed(share=0.5, text='half')

    Raises:
        Malformed: it is none.
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
                return NotDone(_text(message["text"]))
    except (KeyError, TypeError, ValueError, AttributeError, OverflowError):
        pass
    raise Malformed


def _text(written: Any) -> str:
    """One line, of bounded length, that can be encoded."""
    return " ".join(str(written).encode(errors="replace").decode().split())[:MAX_TEXT]


def _waypoints(written: Any) -> tuple[WaypointEnu, ...]:
    waypoints = []
    for east_m, north_m, up_m in written[:MAX_WAYPOINTS]:
        waypoint = WaypointEnu(float(east_m), float(north_m), None if up_m is None else float(up_m))
        if not all(metres is None or math.isfinite(metres) for metres in waypoint):
            raise Malformed
        waypoints.append(waypoint)
    return tuple(waypoints)
