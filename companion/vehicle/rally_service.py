"""The rally points of the autopilot over MAVLink, before a flight: read and written. No I/O.

A point is written with its altitude above home. PX4's Return knows that frame, and the one above
the sea, by their numbers without `_INT` alone. The altitude is that of the ground: it returns at
RTL_RETURN_ALT above that, and lands on it.

Source: https://mavlink.io/en/services/mission.html; PX4 1.16, src/modules/navigator/rtl.cpp
(setSafepointAsDestination), rtl_direct.cpp.
"""

from __future__ import annotations

from collections.abc import Sequence

from companion.mavlink.framing import Message, dialect, source
from companion.mavlink.plan_transfer import TRANSFER_MESSAGES, PlanItem
from companion.rally_points import RallyPoint, StoredRally, are_same
from companion.vehicle.outcome import Outcome
from companion.vehicle.own_uploads import OwnItems, UploadedItems
from companion.vehicle.plan_store import PlanStore
from companion.vehicle.services import Moment
from companion.vehicle.telemetry import Telemetry
from companion.vehicle.wire import AUTOPILOT, Wire

RALLY = dialect.MAV_MISSION_TYPE_RALLY
POINT = dialect.MAV_CMD_NAV_RALLY_POINT
ABOVE_HOME = dialect.MAV_FRAME_GLOBAL_RELATIVE_ALT
SAME_M = 0.2
"""Points that are nearer to each other are the same; the protocol rounds to a centimetre."""


class RallyService:
    """Fulfils `store_port.AutopilotRally`, and is a service of the vehicle.

    Args:
        wire: whose system the autopilot belongs to.
        telemetry: what it says.
        own: the rally points that this companion has written.
    """

    wanted = TRANSFER_MESSAGES
    needs_control = True

    def __init__(self, wire: Wire, telemetry: Telemetry, own: OwnItems) -> None:
        self._store = PlanStore(wire, telemetry, RALLY, own)
        self._telemetry, self._own = telemetry, own

    # -- store_port.AutopilotRally -------------------------------------------------------------

    @property
    def stored(self) -> StoredRally | None:
        """Those that were read last; None before, and where it is not known where they lie."""
        items = self._store.items
        return None if items is None else self._rally(items)

    @property
    def has_written(self) -> bool:
        """Whether this companion has ever written some, to whichever vehicle."""
        return bool(self._own.written)

    @property
    def outcome(self) -> Outcome:
        """What has become of the last `read` or `write`."""
        return self._store.outcome

    def locate(self) -> Outcome:
        """Asks where the autopilot's frame lies on the earth."""
        return self._store.locate()

    def read(self) -> None:
        """Begins to ask for them."""
        self._store.read("the autopilot does not tell its rally points")

    def write(self, points: Sequence[RallyPoint]) -> None:
        """Begins to put some, or none, in the place of those that are there."""
        items = [self._item(point) for point in points]
        known = tuple(item for item in items if item is not None)
        purpose = f"the autopilot does not take {StoredRally(tuple(points))}"
        self._store.write(known if len(known) == len(items) else None, purpose)

    def is_as_written(self) -> bool:
        """Whether what was read last is what was written last, wherever the frame is by now."""
        return self._store.is_as_written()

    def is_own(self) -> bool:
        """Whether what was read last was written by this companion, now or in another flight."""
        theirs = self.stored
        if theirs is None or theirs.flaw is not None or not theirs.points:
            return False
        written = filter(None, map(self._rally, self._own.written))
        return any(are_same(ours.points, theirs.points, SAME_M) for ours in written)

    def _item(self, point: RallyPoint) -> PlanItem | None:
        there = self._telemetry.frame.on_earth(point.position)
        if there is None or point.up_m is None:
            return None
        x, y = (round(degrees * 1e7) for degrees in there)
        return PlanItem(POINT, ABOVE_HOME, 0.0, x, y, point.up_m)

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

    # -- services.Service ----------------------------------------------------------------------

    def step(self, moment: Moment) -> None:
        """Time has passed."""
        self._store.step(moment)

    def take(self, moment: Moment, message: Message) -> None:
        """Takes what the autopilot says of its plans."""
        if source(message)[1] == AUTOPILOT:
            self._store.take(moment, message)

    def due(self, moment: Moment) -> list[Message]:
        """What has to be said now."""
        return self._store.due(moment)

    def release(self) -> None:
        """Asks for nothing any longer."""
        self._store.forget()
