"""Which rows leave the vehicle no chance: they say nothing of it, and count for nothing.

A campaign that lays an obstacle anywhere lays it onto a place of the mission now and then, or so
near to the start that the vehicle stands in it. Both are seen before the flight. What appears on
top of a flying vehicle is seen when it does (measuring.py).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from companion.mission.model import Mission

if TYPE_CHECKING:
    from collections.abc import Set

    from companion.api.simulating import Scenario

AROUND_PLACE_M = 0.5
"""What has to be left free around a place, beside the vehicle itself."""


def unfair(mission: Mission, scenario: Scenario, moved: Set[str]) -> str:
    """Why a row is unfair; "" if it is fair.

    An obstacle that no factor moves stands where the author of the scenario wants it, and is fair
    wherever that is. One that is never there is fair, too.

    Args:
        mission: what is flown.
        scenario: of the row.
        moved: names of the obstacles that the row has placed.
    """
    for obstacle in scenario.met_obstacles:
        if obstacle.name not in moved:
            continue
        least_m = scenario.vehicle.radius_m + AROUND_PLACE_M
        for place in mission.places.values():
            if obstacle.distance_m(place.position[:2]) < least_m:
                return f"the obstacle {obstacle.name} on {place.name}"
    return ""
