"""Reads what a mission does when no plan exists, and checks the places where it then lands.

The autopilot lands where the vehicle is, without looking. So a safe place has to be known from the
beginning, lie above the ground, and have no wall with a top nearby.
"""

from __future__ import annotations

from collections.abc import Mapping

from companion.documents import Document, did_you_mean
from companion.errors import MissionError
from companion.mission.landing_sites import MANY
from companion.mission.otherwise import LandAtSafePlace, Otherwise
from companion.mission.places import Place
from companion.mission.schema import MissionFile
from companion.motion.grid import OccupancyGrid
from companion.vehicle_profile import VehicleProfile

KEYS = ("otherwise", "land_at")


def read_otherwise(
    file: MissionFile,
    places: Mapping[str, Place],
    grid: OccupancyGrid,
    vehicle: VehicleProfile,
    document: Document,
) -> Otherwise | LandAtSafePlace:
    """What a mission does when no plan exists.

    Args:
        places: the mission's places, checked.
        grid: its map.
        vehicle: the vehicle that lands.
        document: the mission's YAML.

    Raises:
        MissionError: at the first place that is not safe.
    """
    if isinstance(file.otherwise, str):
        return Otherwise(file.otherwise)
    names = tuple(file.otherwise.land_at)
    for index, name in enumerate(names):
        if problem := _problem(name, names[:index], places, grid, vehicle):
            what, hint = problem
            raise MissionError(what, document.where(*KEYS, index), hint)
    return LandAtSafePlace(names)


def _problem(
    name: str,
    before: tuple[str, ...],
    places: Mapping[str, Place],
    grid: OccupancyGrid,
    vehicle: VehicleProfile,
) -> tuple[str, str] | None:
    """Why the vehicle cannot be sent to land at a place, and the remedy; None if it can."""
    if name not in places:
        hint = f"places are {', '.join(places)}. {did_you_mean(name, places)}"
        return f"unknown place {name} in land_at", hint.rstrip()
    if name in before:
        return f"{name} is twice in land_at", "remove one of them"
    place = places[name]
    if place.found_by:
        what = f"{name} is found in flight: until then nobody knows where it lies"
        return what, "write places that are known from the beginning"
    for north, east, _ in (place.position, *place.region.waypoints(place.position, MANY, 0.0)):
        _, highest_m = grid.ground_m((north, east), vehicle.clearance_m)
        if highest_m > 0:
            what = f"{name}, to land at, lies above or beside a wall of {highest_m:g} m"
            return what, "the autopilot lands without looking: write a place on open ground"
    return None
