"""What the acting side knows of functions of installed packages: loaded, called, asked, left.

`companion/skills/runner.py` fulfils the port with processes; tests fulfil it with a script. Nothing
here waits, but that in lockstep simulated time waits for what `take` and `awaited` return.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Protocol

from companion.geometry import enu_from_ned
from companion.mission.model import Place
from companion.skills.authoring import KnownPlace, KnownVehicle
from companion.skills.calls import Answer, CallRequest, Function, NotDone
from companion.vehicle.port import FrameLocation, VehicleState


class FunctionPort(Protocol):
    """Calls functions of installed packages."""

    def prepare(self, functions: Iterable[Function]) -> None:
        """Begin to load these; others are not needed any longer."""

    def awaited(self) -> tuple[str, ...] | NotDone:
        """Those that are still being loaded; or why one cannot be."""

    def begin(self, request: CallRequest) -> int:
        """Begin a call; returns a ticket for it."""

    def take(self, ticket: int, now_s: float) -> Sequence[Answer]:
        """What a call has said since it was last asked; `Returned` and `NotDone` are its end."""

    def reply(self, ticket: int, failure: str | None) -> None:
        """What has become of the command that a call has asked for; None if it was done."""

    def cancel(self, ticket: int) -> None:
        """Nobody waits for a call any more; it may have ended."""

    def end_calls(self) -> None:
        """The same for all calls under way."""


class NoFunctions:
    """Calls none: for flights that nobody has given a runner."""

    def prepare(self, functions: Iterable[Function]) -> None:
        """Loads nothing."""

    def awaited(self) -> tuple[str, ...]:
        """Nothing is being loaded."""
        return ()

    def begin(self, request: CallRequest) -> int:
        """Begins nothing."""
        return 0

    def take(self, ticket: int, now_s: float) -> list[Answer]:
        """It has failed."""
        return [NotDone("nothing runs functions of packages here")]

    def reply(self, ticket: int, failure: str | None) -> None:
        """Nobody has asked."""

    def cancel(self, ticket: int) -> None:
        """Nothing is under way."""

    def end_calls(self) -> None:
        """Nothing is under way."""


def known_place(place: Place, location: FrameLocation | None) -> KnownPlace:
    """What a function may know of a place."""
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
    """What a function may know of the vehicle."""
    if state is None:
        return None
    east_m, north_m, up_m = (round(metres, 3) for metres in enu_from_ned(state.position))
    heading_deg = round(math.degrees(state.yaw_rad) % 360, 1)
    percent = state.battery_percent
    return KnownVehicle(east_m, north_m, up_m, heading_deg, state.is_landed, percent)
