"""The port to functions of installed packages: load, call, ask and cancel them.

`companion/skills/runner.py` implements the port with processes, tests implement it with a script.
No method waits, except that in lockstep simulated time waits for what `take` and `awaited` return.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Protocol

from companion.geometry import enu_from_ned
from companion.mission.places import Place
from companion.outcomes import Failed
from companion.skills.authoring import KnownPlace, KnownVehicle
from companion.skills.calls import Answer, CallRequest, Function
from companion.vehicle.ports.frame import FrameLocation
from companion.vehicle.ports.state import VehicleState


class FunctionPort(Protocol):
    """Calls functions of installed packages."""

    def prepare(self, functions: Iterable[Function]) -> None:
        """Begins to load these functions; others are no longer needed."""

    def awaited(self) -> tuple[str, ...] | Failed:
        """The functions that are still being loaded, or why one cannot be loaded."""

    def begin(self, request: CallRequest) -> int:
        """Begins a call; returns a ticket for it."""

    def take(self, ticket: int, now_s: float) -> Sequence[Answer]:
        """What a call has said since the last time; `Returned` and `Failed` end it."""

    def reply(self, ticket: int, failure: str | None) -> None:
        """Tells a call the outcome of the command that it asked for; None if it was done."""

    def cancel(self, ticket: int) -> None:
        """Cancels a call, which may have ended already."""

    def end_calls(self) -> None:
        """Cancels all calls."""


class NoFunctions:
    """Calls no functions: for flights without a runner."""

    def prepare(self, functions: Iterable[Function]) -> None:
        """Loads nothing."""

    def awaited(self) -> tuple[str, ...]:
        """Nothing is being loaded."""
        return ()

    def begin(self, request: CallRequest) -> int:
        """Begins nothing."""
        return 0

    def take(self, ticket: int, now_s: float) -> list[Answer]:
        """Returns a failure."""
        return [Failed("nothing runs functions of packages here")]

    def reply(self, ticket: int, failure: str | None) -> None:
        """Does nothing: no call has asked."""

    def cancel(self, ticket: int) -> None:
        """Does nothing: no call is under way."""

    def end_calls(self) -> None:
        """Does nothing: no call is under way."""


def known_place(place: Place, location: FrameLocation | None) -> KnownPlace:
    """What a function may know about a place."""
    east_m, north_m, up_m = (round(metres, 3) for metres in enu_from_ned(place.position))
    if location is None:
        return KnownPlace(place.name, east_m, north_m, up_m)
    lat_deg, lon_deg, amsl_m = location.zero.to_global(place.position)
    return KnownPlace(
        place.name,
        east_m,
        north_m,
        up_m,
        lat_deg=round(lat_deg, 7),
        lon_deg=round(lon_deg, 7),
        amsl_m=round(amsl_m, 2),
    )


def known_vehicle(state: VehicleState | None) -> KnownVehicle | None:
    """What a function may know about the vehicle."""
    if state is None:
        return None
    east_m, north_m, up_m = (round(metres, 3) for metres in enu_from_ned(state.motion.position))
    heading_deg = round(math.degrees(state.attitude.yaw_rad) % 360, 1)
    percent = state.battery.percent
    return KnownVehicle(east_m, north_m, up_m, heading_deg, state.is_landed, percent)
