"""The geofence: areas to stay in and areas to stay out of.

A fence is a set of polygons and circles, all of which must be obeyed: the vehicle stays inside
areas of inclusion and outside areas of exclusion. GF_MAX_HOR_DIST and GF_MAX_VER_DIST also limit
the distance from home; 0 is no limit. As in PX4, an area that home or a flying vehicle already
violates is not accepted.

Source: PX4 1.16, src/modules/navigator/geofence.cpp. Left out: a prediction of the path
(GF_PREDICT); the fence return point, which PX4 stores but does not use.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from companion.geofence import FenceArea
from companion.geometry import Ned, horizontal_distance
from sitl.autopilot.parameters import Parameters


class Geofence:
    """The fence of one vehicle.

    Attributes:
        areas: those in force.
    """

    def __init__(self) -> None:
        self.areas: tuple[FenceArea, ...] = ()

    def load(self, areas: Sequence[FenceArea], kept_to: Mapping[str, Ned]) -> list[str]:
        """Replaces all areas.

        Args:
            areas: the new ones.
            kept_to: points by name, which every area must allow.

        Returns:
            The names of points that some area does not allow; such an area is left out.
        """
        points = kept_to.values()
        self.areas = tuple(area for area in areas if all(map(area.allows, points)))
        return [n for area in areas for n, point in kept_to.items() if not area.allows(point)]

    def is_breached(self, position: Ned, home: Ned, parameters: Parameters) -> bool:
        """Whether a position is outside the fence or too far from home."""
        most_away_m = parameters["GF_MAX_HOR_DIST"]
        if most_away_m > 0 and horizontal_distance(position, home) >= most_away_m:
            return True
        most_above_m = parameters["GF_MAX_VER_DIST"]
        if most_above_m > 0 and home[2] - position[2] >= most_above_m:
            return True
        return not all(area.allows(position) for area in self.areas)
