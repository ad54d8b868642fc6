"""Reads and writes the autopilot's rally points over MAVLink, before a flight. No I/O.

A point is written with its altitude above home. PX4's Return accepts this frame, and that above the
sea, only by their numbers without `_INT`. The altitude is that of the ground: the vehicle returns
at RTL_RETURN_ALT above it, and lands there.

Source: https://mavlink.io/en/services/mission.html; PX4 1.16, src/modules/navigator/rtl.cpp
(setSafepointAsDestination), rtl_direct.cpp.
"""

from __future__ import annotations

from collections.abc import Sequence

from companion.mavlink.framing import dialect
from companion.mavlink.item_transfer import StoredItem
from companion.rally_points import RallyPoint, StoredRally
from companion.vehicle.item_store import ItemStore
from companion.vehicle.own_uploads import OwnItems, UploadedItems
from companion.vehicle.telemetry import Telemetry
from companion.vehicle.wire import Wire

RALLY = dialect.MAV_MISSION_TYPE_RALLY
POINT = dialect.MAV_CMD_NAV_RALLY_POINT
ABOVE_HOME = dialect.MAV_FRAME_GLOBAL_RELATIVE_ALT


class RallyService(ItemStore):
    """Implements `ports.stores.AutopilotRally`; a service of the vehicle.

    Args:
        wire: of the system that the autopilot belongs to.
        telemetry: of the autopilot.
        own: the rally points that this companion has written.
    """

    def __init__(self, wire: Wire, telemetry: Telemetry, own: OwnItems) -> None:
        super().__init__(wire, telemetry, RALLY, own, "rally points")

    # -- ports.stores --------------------------------------------------------------------------

    @property
    def stored(self) -> StoredRally | None:
        """The points that were read last; None before that, or if their place is not known."""
        return None if self.items is None else self._rally(self.items)

    @property
    def has_written(self) -> bool:
        """Whether this companion has ever written rally points, to any vehicle."""
        return bool(self._own.written)

    def write(self, points: Sequence[RallyPoint]) -> None:
        """Begins to replace the stored points by others, or by none."""
        items = [self._item(point) for point in points]
        known = tuple(item for item in items if item is not None)
        purpose = f"the autopilot does not take {StoredRally(tuple(points))}"
        self._write(known if len(known) == len(items) else None, purpose)

    def is_own(self) -> bool:
        """Whether this companion wrote the points that were read last, now or in another flight."""
        theirs = self.stored
        if theirs is None or not theirs.points:
            return False
        written = filter(None, map(self._rally, self._own.written))
        return any(theirs.consists_of(ours.points) for ours in written)

    def _item(self, point: RallyPoint) -> StoredItem | None:
        there = self._telemetry.frame.on_earth(point.position)
        if there is None or point.up_m is None:
            return None
        x, y = (round(degrees * 1e7) for degrees in there)
        return StoredItem(POINT, ABOVE_HOME, 0.0, x, y, point.up_m)

    def _rally(self, items: UploadedItems) -> StoredRally | None:
        points: list[RallyPoint] = []
        flaw: str | None = None
        for item in items:
            at = self._telemetry.frame.from_earth(item.x / 1e7, item.y / 1e7)
            if at is None:
                return None
            if item.command != POINT:
                flaw = f"it has an item of the command {item.command}"
            is_above_home = item.frame == ABOVE_HOME
            points.append(RallyPoint(at, item.altitude_m if is_above_home else None))
        return StoredRally(tuple(points), flaw)
