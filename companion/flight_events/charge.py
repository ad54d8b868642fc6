"""Events about the charge of the battery: what is there, and what a plan reckons with."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from companion.flight_events.event import FlightEvent
from companion.flight_events.event_fields import Doc


@dataclass(frozen=True, slots=True)
class ChargeMeasured(FlightEvent):
    """The gauge of the battery shows another charge; recorded once a second at most."""

    kind = "battery"
    template = "the battery is at {words}"
    is_told = False

    percent: Annotated[int | None, Doc("the charge by the gauge; null if unknown")]

    @property
    def words(self) -> str:
        """The charge, in words."""
        return "an unknown charge" if self.percent is None else f"{self.percent} %"


@dataclass(frozen=True, slots=True)
class PlannedCharge:
    """The charge at a position to come."""

    action: Annotated[str, Doc("that leads to it, as the mission spells it")]
    duration_s: Annotated[float, Doc("seconds that it is expected to take")]
    percent: Annotated[float, Doc("of the charge, which is expected there at least")]
    required_percent: Annotated[float, Doc("of the charge, which the rest of the plan takes")]


@dataclass(frozen=True, slots=True)
class ChargePlanned(FlightEvent):
    """The charge that the plan expects until its next lap is done, in missions with a battery."""

    kind = "charge"
    template = "at least {percent:.1f} % are expected, {required_percent:.1f} % are required"
    is_told = False

    percent: Annotated[float, Doc("the least charge that is expected")]
    required_percent: Annotated[float, Doc("the charge that the rest of the plan requires")]
    reserve_percent: Annotated[float, Doc("the reserve, in percent of the charge")]
    ahead: Annotated[
        tuple[PlannedCharge, ...],
        Doc(
            "the later positions, until a lap is done: a list of `{action, duration_s, percent, "
            "required_percent}`"
        ),
    ]
