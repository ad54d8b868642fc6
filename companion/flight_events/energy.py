"""Events about the energy that flights take, and about the gauge that tells what is left."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from companion.flight_events.event import FlightEvent
from companion.flight_events.event_fields import Doc


@dataclass(frozen=True, slots=True)
class EnergyUsed(FlightEvent):
    """A stretch between two charges was flown: what it took, and what was expected of it."""

    kind = "energy"
    template = (
        "flown {seconds:.0f} s on {used_wh:.2f} Wh, {expected_wh:.2f} Wh were expected; "
        "flights take {factor:.2f} times what the mission says"
    )

    seconds: Annotated[float, Doc("of flights and other skills")]
    used_wh: Annotated[float, Doc("by voltage and current; without a current, by the gauge")]
    expected_wh: Annotated[
        float, Doc("by the mission's figures, times what was known of them at its beginning")
    ]
    factor: Annotated[float, Doc("what is known now, by the gauge's percents too")]


@dataclass(frozen=True, slots=True)
class ReserveUsed(FlightEvent):
    """Nothing is left above the reserve: it is used to land where that takes the least."""

    kind = "energy"
    template = "{reserve_wh:.2f} Wh of the reserve are used on the way to the next landing"

    reserve_wh: Annotated[float, Doc("that the charge lacks for a landing with the reserve left")]


@dataclass(frozen=True, slots=True)
class GaugeJumped(FlightEvent):
    """The battery's gauge has jumped in flight; what is less is believed."""

    kind = "energy"
    template = (
        "the battery's gauge jumps from {before_percent} % to {now_percent} %: "
        "{believed_percent} % are believed"
    )

    before_percent: Annotated[int, Doc("what was believed before")]
    now_percent: Annotated[int, Doc("what the gauge tells")]
    believed_percent: Annotated[int, Doc("what is believed now")]
