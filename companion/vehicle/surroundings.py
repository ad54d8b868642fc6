"""Corrects the map by range scans, and the mission's frame by the walls of the map.

The walls of the mission's map are the reference. If a scan does not match them, position and
heading are wrong by the difference, and the mission's frame is moved by a part of it. So a vehicle
that sees these walls keeps its distance from them, whatever its GPS says. If the position is exact,
the walls may be wrong instead, and the frame is not moved. Scans that arrive together, as after a
pause of the process, were all placed before the first of them moved the frame; they are moved along
with it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from companion.geometry import Ned
from companion.motion.grid import OccupancyGrid
from companion.motion.position_error import EXACT_M, greatest_error_m
from companion.motion.range_scan import RangeScan
from companion.motion.sensed_map import SensedMap
from companion.motion.wall_alignment import GREATEST_TURN_RAD, WallAlignment
from companion.vehicle.telemetry import Telemetry

SHARE = 0.3
"""The frame is moved by this fraction of a scan's error, as one scan may be wrong."""


class Surroundings:
    """The map of a mission, corrected by scans, and the frame, corrected by the map.

    Args:
        prior: the map of the mission.
        telemetry: of the vehicle; this class moves its frame.
    """

    def __init__(self, prior: OccupancyGrid, telemetry: Telemetry) -> None:
        self._map = SensedMap(prior)
        self._walls = WallAlignment(prior)
        self._telemetry = telemetry
        self._turn_rad = 0.0  # the last known error of the heading

    @property
    def grid(self) -> OccupancyGrid:
        """The map as it is known now; a new object exactly when a cell has changed."""
        return self._map.grid

    def take(self, scans: Iterable[RangeScan]) -> bool:
        """Takes scans in order; returns whether a cell has become occupied or free."""
        placed_by = self._telemetry.frame.origin
        changes = [
            self._map.integrate(self._aligned(self._moved(scan, placed_by))) for scan in scans
        ]
        return any(changes)

    def _moved(self, scan: RangeScan, placed_by: Ned | None) -> RangeScan:
        """A scan in the present frame; `placed_by` is the frame's origin when it was placed."""
        origin = self._telemetry.frame.origin
        if origin is None or placed_by is None or origin == placed_by:
            return scan
        north, east = scan.position
        by_north, by_east = placed_by[0] - origin[0], placed_by[1] - origin[1]
        return replace(scan, position=(north + by_north, east + by_east))

    def _aligned(self, scan: RangeScan) -> RangeScan:
        accuracy_m = self._telemetry.accuracy_m
        if accuracy_m <= EXACT_M:
            return scan
        greatest_m = greatest_error_m(accuracy_m)
        turned = replace(scan, yaw_rad=scan.yaw_rad + self._turn_rad)
        off = self._walls.displacement(turned, greatest_m)
        self._telemetry.placed.move((SHARE * off.north_m, SHARE * off.east_m), greatest_m)
        turn_rad = self._turn_rad + off.turn_rad
        self._turn_rad = min(max(turn_rad, -GREATEST_TURN_RAD), GREATEST_TURN_RAD)
        return off.applied(turned)
