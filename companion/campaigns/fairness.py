"""Finds rows in which the vehicle has no chance; they count for nothing.

A campaign that may place an obstacle anywhere will sometimes place it on a place of the mission, or
where the vehicle stands at the start. This module finds both before the flight. measuring.py finds
obstacles that appear on top of a flying vehicle.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from companion.mission.model import Mission

if TYPE_CHECKING:
    from collections.abc import Set

    from companion.flights.simulated_world import Scenario

AROUND_PLACE_M = 0.5
"""What must be free around a place, in addition to the vehicle's radius."""


def unfair(mission: Mission, scenario: Scenario, moved: Set[str]) -> str:
    """Why a row is unfair; "" if it is fair.

    An obstacle that no factor moves stands where the author of the scenario wants it, so it is
    always fair. So is an obstacle that is never present.
    wherever that is. One that is never there is fair, too.

    Args:
        scenario: the scenario of the row.
        moved: names of the obstacles that the row places.
    """
    for obstacle in scenario.met_obstacles:
        if obstacle.name not in moved:
            continue
        least_m = scenario.vehicle.radius_m + AROUND_PLACE_M
        for place in mission.places.values():
            if obstacle.distance_m(place.position[:2]) < least_m:
                return f"the obstacle {obstacle.name} on {place.name}"
    return ""
