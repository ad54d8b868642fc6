"""For authors of functions: how to mark one, and what it may ask of the companion.

    from companion.skills import Failed, skill

    @skill
    def weigh(run, place: str, limit_kg: float = 2.0):
        for kg in read_scale():
            run.progress(kg / limit_kg)
            if kg > limit_kg:
                raise Failed(f"{kg} kg")

Each call of the function runs in a process of its own, so it may block. It knows only what it is
given of the vehicle. To command a payload, it asks the companion.
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
"""MAVLink sends the parameters of commands as IEEE 754 single-precision numbers."""
MAX_PARAMETERS = 7
"""Number of parameters of COMMAND_LONG."""


class FunctionKind(Enum):
    """The purpose of an installed function; the value is the group of its entry point."""

    SKILL = "companion.skills"
    SUGGESTER = "companion.suggesters"
    PLACE_TEST = "companion.place_tests"


class SkillFailure(Exception):
    """The skill has failed; the text says why, in a few words."""


class Cancelled(BaseException):
    """The mission has left the skill. No `except Exception` catches it: clean up in `finally`."""


def skill(function: F) -> F:
    """Marks `function(run, ...)` as a skill, which has succeeded when the function returns."""
    return _marked(function, FunctionKind.SKILL)


def suggester(function: F) -> F:
    """Marks `function(run, place, ...)`, which yields waypoints for a place, the best first."""
    return _marked(function, FunctionKind.SUGGESTER)


def place_test(function: F) -> F:
    """Marks `function(run, place, waypoint, ...)`, which says whether the waypoint is allowed."""
    return _marked(function, FunctionKind.PLACE_TEST)


def _marked(function: F, kind: FunctionKind) -> F:
    setattr(function, MARK, kind.value)
    return function


@dataclass(frozen=True, slots=True)
class KnownPlace:
    """A place of the mission; latitude, longitude and altitude above sea level if known."""

    name: str
    east_m: float
    north_m: float
    up_m: float
    lat_deg: float | None = None
    lon_deg: float | None = None
    amsl_m: float | None = None


class WaypointEnu(NamedTuple):
    """A point of a place's region, in metres from home; without `up_m`, at the place's height."""

    east_m: float
    north_m: float
    up_m: float | None = None


@dataclass(frozen=True, slots=True)
class KnownVehicle:
    """The vehicle's state when the call began."""

    east_m: float
    north_m: float
    up_m: float
    heading_deg: float
    is_landed: bool
    battery_percent: int | None = None


def why_not_carried(parameters: Sequence[float]) -> str | None:
    """Why no command can have these parameters; None if one can, also with NaN.

    >>> why_not_carried((1.0, math.nan)), why_not_carried((1e39,))
    (None, '1e+39 is not a number of single precision, as commands have')
    """
    if len(parameters) > MAX_PARAMETERS:
        return f"a command has {MAX_PARAMETERS} parameters at most"
    too_large = (each for each in parameters if abs(each) > FLOAT32_MAX)
    return next(
        (f"{each:g} is not a number of single precision, as commands have" for each in too_large),
        None,
    )


class Interlocutor(Protocol):
    """The companion, as a call talks to it."""

    def progress(self, share: float | None, text: str) -> None:
        """Reports progress."""

    def sleep(self, seconds: float) -> None:
        """Returns after this much time of the flight."""

    def command(self, component: str | int, command: str, parameters: tuple[float, ...]) -> None:
        """Returns when the payload has done it."""

    @property
    def is_cancelled(self) -> bool:
        """Whether the result of the call is not awaited any more."""


class FunctionRun:
    """One call, as its function sees it.

    Attributes:
        places: those among the arguments, by name.
        vehicle: its state when the call began; None if unknown.

    Args:
        companion: what the call talks to.
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
        """Reports progress: a share from 0 to 1, a few words, or both.

        Raises:
            Cancelled: the mission has left the skill.
        """
        if share is not None and not math.isfinite(share):
            share = None
        self._companion.progress(share, str(text))

    def sleep(self, seconds: float) -> None:
        """Waits by the flight's clock, which is simulated time in a simulated flight.

        Raises:
            Cancelled: the mission has left the skill.
        """
        if not 0 <= seconds <= 86_400:
            raise ValueError(f"{seconds} is not a time to sleep; give 0 to 86400 seconds")
        self._companion.sleep(float(seconds))

    def command(self, component: str | int, command: str, *parameters: float) -> None:
        """Asks the companion to send a command to a payload, and waits until it is done.

        Args:
            component: a name in the mission's `components`, or a MAVLink component id.
            command: the name of a MAV_CMD for payloads.
            parameters: param1 to param7; those left out are 0, NaN is sent as it is.

        Raises:
            ValueError: more than seven parameters, or one that is no single-precision number.
            Failed: it was refused, or has failed.
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
