"""Finds places at which the error of the autopilot's height may bring the vehicle to the ground.

A map and the heights of places are as exact as their author says. The autopilot's height is not, if
its position comes from GPS and its height from air pressure. In PX4's simulator the height was off
by 0.3 to 0.75 m (RMS of a flight) and by 1.4 m at worst, while PX4 reported 0.16 to 0.33 m. So it
flew 0.5 m above the ground where 1.5 m was asked for. Such places cause a notice only; nothing is
flown higher, because the author may know better.

Left out: what hangs above a place, because no map contains it; and the lower end of the altitude
band, because nothing is flown lower than the lowest place.
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
    """A place near the ground, or near the top of a low wall below it.

    Attributes:
        above_m: height of the place above what is below it.
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
    """The least height above what is below, for a vehicle that does not know its height exactly.

    >>> least_above_m(VehicleProfile())
    1.5
    """
    return round(WORST_HEIGHT_M + profile.margin_m, 2)


def low_places(planner: Planner) -> tuple[LowPlace, ...]:
    """The places that a mission flies to below `least_above_m`, in the mission's order.

    >>> from companion import load_mission
    >>> low_places(Planner(load_mission("missions/delivery.yaml")))
    ()
    """
    flown_to = {action.destination for action in planner.actions.every()}
    return low_among(planner.mission, flown_to)


def low_among(mission: Mission, flown_to: Collection[str | None]) -> tuple[LowPlace, ...]:
    """The low ones among some places, the place where the mission begins, and the safe places.

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
