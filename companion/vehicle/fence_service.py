"""Reads and writes the autopilot's fence over MAVLink, and hears its objections to it. No I/O.

1. PX4 accepts any fence and reads it back unchanged, but does not enforce an area that does not
   contain its home. It reports this by an EVENT, and by a STATUSTEXT where a ground station is
   heard. This service listens to both.
2. PX4 does not reload identical items. So a fence that is written again begins with another corner.
3. A fence that PX4 would interpret otherwise than it is drawn is not written.
4. MISSION_CURRENT has a number that differs for another fence, and is 0 without one. During our
   own write it is not known.

Source: https://mavlink.io/en/services/mission.html; PX4 1.16, src/modules/navigator/geofence.cpp.
"""

from __future__ import annotations

from collections.abc import Sequence

from companion.geofence import FenceArea, StoredFence
from companion.geometry import NorthEast
from companion.mavlink.framing import Message, dialect, source
from companion.mavlink.item_transfer import TRANSFER_MESSAGES, StoredItem
from companion.vehicle.fence_items import fence_of, items_of
from companion.vehicle.item_store import ItemStore
from companion.vehicle.own_uploads import OwnItems, UploadedItems
from companion.vehicle.services import Moment
from companion.vehicle.telemetry import Telemetry
from companion.vehicle.wire import AUTOPILOT, Wire

FENCE = dialect.MAV_MISSION_TYPE_FENCE
OBJECTION = "Geofence invalid"
OBJECTIONS = {
    10973461: "Geofence invalid, doesn't contain Home position",
    9432105: "Geofence invalid, doesn't contain current vehicle position",
}
"""Ids of PX4's events, without the component in the upper byte."""
MOST_OBJECTIONS = 8


class FenceService(ItemStore):
    """Implements `ports.stores.AutopilotFence`; a service of the vehicle.

    Args:
        wire: of the system that the autopilot belongs to.
        telemetry: of the autopilot.
        own: the fences that this companion has written.
    """

    wanted = TRANSFER_MESSAGES | {"HOME_POSITION", "STATUSTEXT", "EVENT", "MISSION_CURRENT"}

    def __init__(self, wire: Wire, telemetry: Telemetry, own: OwnItems) -> None:
        super().__init__(wire, telemetry, FENCE, own, "fence")
        self._home: tuple[float, float] | None = None
        self._objections: list[str] = []
        self._number: int | None = None

    # -- ports.stores --------------------------------------------------------------------------

    @property
    def stored(self) -> StoredFence | None:
        """The fence that was read last; None before that, or if its place is not known."""
        return None if self.items is None else self._fence(self.items)

    @property
    def home(self) -> NorthEast | None:
        """The autopilot's home in the mission's frame; None if not known."""
        return None if self._home is None else self._telemetry.frame.from_earth(*self._home)

    @property
    def objections(self) -> Sequence[str]:
        """What the autopilot has said since the last `write` about areas that it does not
        enforce."""
        return tuple(self._objections)

    @property
    def number(self) -> int | None:
        """The number of the fence by rule 4; None if not known."""
        return self._number

    def write(self, areas: Sequence[FenceArea]) -> None:
        """Begins to replace the stored fence; applies rules 2 and 3."""
        on_earth = self._telemetry.frame.on_earth
        items = items_of(areas, on_earth)
        if items is not None and items == self.items:
            items = items_of(areas, on_earth, first=1)
        self._objections, self._number = [], None
        read = None if items is None else self._fence(items)
        if read is not None and read.flaw is not None:
            self._refuse(f"PX4 cannot keep the mission's fence: {read.flaw}")
            return
        points = "" if items is None else f" of {len(items)} points"
        self._write(items, f"the autopilot does not take a fence{points}")

    def is_own(self) -> bool:
        """Whether this companion wrote the fence that was read last, now or in another flight."""
        return any(self._is_like_read(items) for items in self._own.written)

    def is_vouched_for(self) -> bool:
        """Whether the fence that was read last is known to be in force."""
        return self.items is not None and self.items == self._own.in_force

    def vouch(self) -> None:
        """Notes that the fence written last was read back, and that nothing was said against it."""
        self._own.in_force = self.written

    def _fence(self, items: Sequence[StoredItem]) -> StoredFence | None:
        return fence_of(items, self._telemetry.frame.from_earth)

    def _is_like_read(self, items: UploadedItems) -> bool:
        ours, theirs = self._fence(items), self.stored
        return ours is not None and theirs is not None and theirs.consists_of(ours.areas)

    # -- services.Service ----------------------------------------------------------------------

    def take(self, moment: Moment, message: Message) -> None:
        """Takes the autopilot's messages about its plans, its home, and faults of the fence."""
        if source(message)[1] != AUTOPILOT:
            return
        match message.get_type():
            case "HOME_POSITION":
                if message.latitude or message.longitude:
                    self._home = message.latitude / 1e7, message.longitude / 1e7
            case "STATUSTEXT":
                if message.text.startswith(OBJECTION):
                    self._object(" ".join(message.text.rstrip("\0").split()))
            case "EVENT":
                if (text := OBJECTIONS.get(message.id & 0xFFFFFF)) is not None:
                    self._object(text)
            case "MISSION_CURRENT":
                self._number = None if self.is_writing else message.fence_id
            case _:
                super().take(moment, message)

    def release(self) -> None:
        """Drops the objections, too."""
        super().release()
        self._objections = []

    def _object(self, text: str) -> None:
        if text not in self._objections and len(self._objections) < MOST_OBJECTIONS:
            self._objections.append(text)
