"""Events about the energy that flights take, and about the gauge that tells what is left."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from companion.flight_events.event import FlightEvent
from companion.flight_events.event_fields import Doc


@dataclass(frozen=True, slots=True)
class EnergyUsed(FlightEvent):
    """A stretch between two charges was flown: the energy that it used, and the expected one."""

    kind = "energy"
    template = (
        "{used_wh:.2f} Wh used in {seconds:.0f} s, {expected_wh:.2f} Wh expected; flights take "
        "{factor:.2f} times the energy that the mission says"
    )

    seconds: Annotated[float, Doc("of flights and other skills")]
    used_wh: Annotated[
        float, Doc("measured by voltage and current; without a current, by the gauge")
    ]
    expected_wh: Annotated[
        float, Doc("by the mission's figures, times the factor that was known at the beginning")
    ]
    factor: Annotated[float, Doc("the factor that is known now, also from the gauge")]


@dataclass(frozen=True, slots=True)
class ReserveUsed(FlightEvent):
    """Only the reserve is left: it is used for the landing that takes the least energy."""

    kind = "energy"
    template = "the way to the next landing uses {reserve_wh:.2f} Wh of the reserve"

    reserve_wh: Annotated[float, Doc("how much of the reserve the landing will use")]


@dataclass(frozen=True, slots=True)
class GaugeJumped(FlightEvent):
    """The battery's gauge jumped in flight; the lower value is believed."""

    kind = "energy"
    template = (
        "the battery's gauge jumped from {before_percent} % to {now_percent} %: "
        "{believed_percent} % is assumed"
    )

    before_percent: Annotated[int, Doc("the charge that was believed before")]
    now_percent: Annotated[int, Doc("the charge by the gauge")]
    believed_percent: Annotated[int, Doc("the charge that is believed now")]
