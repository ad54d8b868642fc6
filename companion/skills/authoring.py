"""What the author of a function sees: how it is marked, and what it may ask of the companion.

    from companion.skills import Failed, skill

    @skill
    def weigh(run, place: str, limit_kg: float = 2.0):
        for kg in read_scale():
            run.progress(kg / limit_kg)
            if kg > limit_kg:
                raise Failed(f"{kg} kg")

The function runs in a process of its own, once for each call, so it may block. It has nothing of
the vehicle but what is handed to it; a command to a payload is asked of the companion.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any, NamedTuple, Protocol, TypeVar

F = TypeVar("F", bound=Callable[..., Any])
MARK = "__companion_kind__"
FLOAT32_MAX = 3.4028234e38
"""MAVLink carries the parameters of commands in IEEE 754 single precision."""
MAX_PARAMETERS = 7
"""Of COMMAND_LONG."""


class FunctionKind(Enum):
    """What an installed function is for; the value is the group of its entry point."""

    SKILL = "companion.skills"
    SUGGESTER = "companion.suggesters"
    PLACE_TEST = "companion.place_tests"


class SkillFailure(Exception):
    """The skill has failed; its text says why, in a few words."""


class Cancelled(BaseException):
    """The mission has left the skill. No `except Exception` catches it: clean up in `finally`."""


def skill(function: F) -> F:
    """Marks `function(run, ...)` as a skill: it has succeeded when it returns."""
    return _marked(function, FunctionKind.SKILL)


def suggester(function: F) -> F:
    """Marks `function(run, place, ...)`, which yields waypoints of a place, the best first."""
    return _marked(function, FunctionKind.SUGGESTER)


def place_test(function: F) -> F:
    """Marks `function(run, place, waypoint, ...)`: whether the waypoint may be flown to."""
    return _marked(function, FunctionKind.PLACE_TEST)


def _marked(function: F, kind: FunctionKind) -> F:
    setattr(function, MARK, kind.value)
    return function


@dataclass(frozen=True, slots=True)
class KnownPlace:
    """A place of the mission; latitude, longitude and height above the sea where they are known."""

    name: str
    east_m: float
    north_m: float
    up_m: float
    lat_deg: float | None = None
    lon_deg: float | None = None
    amsl_m: float | None = None


class WaypointEnu(NamedTuple):
    """A point of a place's region, metres from home; the place's own height without `up_m`."""

    east_m: float
    north_m: float
    up_m: float | None = None


@dataclass(frozen=True, slots=True)
class KnownVehicle:
    """The vehicle as it was when the call began."""

    east_m: float
    north_m: float
    up_m: float
    heading_deg: float
    is_landed: bool
    battery_percent: int | None = None


def why_not_carried(parameters: Sequence[float]) -> str | None:
    """Why no command carries these parameters; None if it does, NaN among them.

    >>> why_not_carried((1.0, math.nan)), why_not_carried((1e39,))
    (None, '1e+39 is no number of single precision, as commands have')
    """
    if len(parameters) > MAX_PARAMETERS:
        return f"a command has {MAX_PARAMETERS} parameters at most"
    too_large = (each for each in parameters if abs(each) > FLOAT32_MAX)
    return next(
        (f"{each:g} is no number of single precision, as commands have" for each in too_large), None
    )


class Interlocutor(Protocol):
    """What a call says to the companion, and asks of it."""

    def progress(self, share: float | None, text: str) -> None:
        """How far it has come."""

    def sleep(self, seconds: float) -> None:
        """Returns after so much time of the flight."""

    def command(self, component: str | int, command: str, parameters: tuple[float, ...]) -> None:
        """Returns when the payload has done it."""

    @property
    def is_cancelled(self) -> bool:
        """Whether nobody waits for the call any more."""


class FunctionRun:
    """One call, as its function sees it.

    Attributes:
        places: those among the arguments, by name.
        vehicle: as it was at the beginning; None where that is not known.

    Args:
        companion: what it speaks with.
    """

    def __init__(
        self,
        companion: Interlocutor,
        places: Mapping[str, KnownPlace],
        vehicle: KnownVehicle | None,
    ) -> None:
        self._companion = companion
        self.places = places
        self.vehicle = vehicle

    def progress(self, share: float | None = None, text: str = "") -> None:
        """Says how far the call has come: a share from 0 to 1, a few words, or both.

        Raises:
            Cancelled: the mission has left the skill.
        """
        if share is not None and not math.isfinite(share):
            share = None
        self._companion.progress(share, str(text))

    def sleep(self, seconds: float) -> None:
        """Waits so long, by the flight's clock: simulated time in a simulated flight.

        Raises:
            Cancelled: the mission has left the skill.
        """
        if not 0 <= seconds <= 86_400:
            raise ValueError(f"{seconds} is no time to sleep; 0 to 86400 seconds")
        self._companion.sleep(float(seconds))

    def command(self, component: str | int, command: str, *parameters: float) -> None:
        """Has the companion send a command to a payload, and waits until that is done.

        Args:
            component: a name of the mission's `components`, or a MAVLink component id.
            command: the name of a MAV_CMD that payloads take.
            parameters: param1 to param7; what is left out is 0, and NaN is sent as it is.

        Raises:
            ValueError: more than seven parameters, or one that no single-precision number holds.
            Failed: it was refused, or not done.
            Cancelled: the mission has left the skill.
        """
        numbers = tuple(float(each) for each in parameters)
        if why_not := why_not_carried(numbers):
            raise ValueError(why_not)
        self._companion.command(component, command, numbers)

    @property
    def is_cancelled(self) -> bool:
        """Whether the mission has left the skill."""
        return self._companion.is_cancelled
