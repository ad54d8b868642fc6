"""Moves places given above the sea to where they are, once the height of home is known.

Until then they are planned as if they lay in the middle of the mission's altitudes
(coordinates.py). The autopilot reports how high home is as soon as the vehicle stands there. From
then on all altitudes count from home.
"""

from __future__ import annotations

from dataclasses import replace

from companion.errors import MissionError
from companion.mission.model import Mission
from companion.mission.places import Place


def above_ground(mission: Mission, ground_amsl_m: float | None) -> Mission:
    """The mission with its places at their altitudes above a home of known height.

    Args:
        mission: may have places given above the sea.
        ground_amsl_m: height of home above mean sea level; None while it is not known.

    Raises:
        MissionError: one of these places lies outside the mission's altitudes.
    """
    if mission.anchor is None or not mission.is_above_sea or ground_amsl_m is None:
        return mission
    places = {name: _above(place, ground_amsl_m) for name, place in mission.places.items()}
    lowest, highest = mission.limits.up_m
    for place in places.values():
        up_m = -place.position[2]
        if not lowest <= up_m <= highest:
            raise MissionError(
                f"place {place.name} is {up_m:.1f} m above home, outside {lowest:g} to "
                f"{highest:g} m: home is {ground_amsl_m:.1f} m above the sea",
                hint="is its amsl_m above mean sea level, not above the ellipsoid?",
            )
    return replace(mission, places=places, anchor=replace(mission.anchor, altitude_m=ground_amsl_m))


def _above(place: Place, ground_amsl_m: float) -> Place:
    if place.amsl_m is None:
        return place
    return replace(place, position=(*place.position[:2], ground_amsl_m - place.amsl_m))
