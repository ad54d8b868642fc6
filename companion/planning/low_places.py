"""Places that are flown to lower than an autopilot's height is certain.

A map is as exact as its author says, and so are the heights of places. The height that an autopilot
believes is not, where its position comes from GPS and its height from the pressure of the air: what
PX4's simulator took for its height was off by 0.3 to 0.75 m (RMS of a flight), 1.4 m at worst, and
it told of 0.16 to 0.33 m. So it flew 0.5 m above the ground where 1.5 m was asked for. Nothing is
flown higher for that: who wrote the height may know better. It is noticed.

Left out: what hangs above a place, which no map has; and the lower end of the altitude band, since
nothing is flown lower than the lowest place.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from companion.mission.model import Mission
from companion.motion.position_error import WORST_HEIGHT_M
from companion.planning.planner import Planner
from companion.vehicle_profile import VehicleProfile


@dataclass(frozen=True, slots=True)
class LowPlace:
    """A place near the ground, or near the wall with an upper end that is below it.

    Attributes:
        above_m: how high it is above what is below it.
    """

    name: str
    above_m: float

    def __str__(self) -> str:
        return f"{self.name} ({self.above_m:g} m)"


def too_low(profile: VehicleProfile) -> str:
    """What is odd about low places, in words.

    >>> print(too_low(VehicleProfile()).partition(", and ")[0])
    flown to so low above what is below
    """
    return (
        "flown to so low above what is below, and the height of a vehicle with GPS may be off by"
        f" {WORST_HEIGHT_M:g} m; write {least_above_m(profile):g} m or more"
    )


def least_above_m(profile: VehicleProfile) -> float:
    """How high above what is below it a vehicle is to fly whose height is not exact.

    >>> least_above_m(VehicleProfile())
    1.5
    """
    return round(WORST_HEIGHT_M + profile.margin_m, 2)


def low_places(planner: Planner) -> tuple[LowPlace, ...]:
    """The places that a mission flies to lower than that, in its own order.

    >>> from companion import load_mission
    >>> low_places(Planner(load_mission("missions/delivery.yaml")))
    ()
    """
    flown_to = {action.destination for action in planner.all_actions()}
    return low_among(planner.mission, flown_to)


def low_among(mission: Mission, flown_to: Collection[str | None]) -> tuple[LowPlace, ...]:
    """Those of some places, and of the ones where it begins and may have to land.

    >>> from companion import load_mission
    >>> low_among(load_mission("missions/delivery.yaml"), ["Depot"])
    ()
    """
    profile = mission.vehicle
    flown_to = {*flown_to, mission.home.name, *mission.safe_places}
    found = []
    for place in mission.places.values():
        if place.name in flown_to:
            ground_m = mission.grid.ground_m(place.position[:2], profile.clearance_m)[1]
            above_m = round(-place.position[2] - ground_m, 2)
            if above_m < least_above_m(profile):
                found.append(LowPlace(place.name, above_m))
    return tuple(found)
