"""The fence of the autopilot over MAVLink: read, written, and what is said of it. No I/O.

1. PX4 takes every fence, reads it back whole, and then leaves out an area that does not hold its
   home. It says so by an event, and where a ground station is heard by a text; both are heard here.
2. PX4 does not load equal items anew; a fence that is written again begins with another corner.

Source: https://mavlink.io/en/services/mission.html; PX4 1.16, src/modules/navigator/geofence.cpp.
"""

from __future__ import annotations

from collections.abc import Sequence

from companion.geofence import FenceArea, StoredFence, are_alike
from companion.geometry import NorthEast
from companion.mavlink.framing import Message, dialect, source
from companion.mavlink.plan_transfer import TRANSFER_MESSAGES, PlanItem
from companion.vehicle.fence_items import fence_of, items_of
from companion.vehicle.outcome import Outcome
from companion.vehicle.own_uploads import OwnItems, UploadedItems
from companion.vehicle.plan_store import PlanStore
from companion.vehicle.services import Moment
from companion.vehicle.telemetry import Telemetry
from companion.vehicle.wire import AUTOPILOT, Wire

FENCE = dialect.MAV_MISSION_TYPE_FENCE
ALIKE_M = 0.2
"""Corners that are nearer to each other are the same."""
OBJECTION = "Geofence invalid"
OBJECTIONS = {
    10973461: "Geofence invalid, doesn't contain Home position",
    9432105: "Geofence invalid, doesn't contain current vehicle position",
}
"""Numbers of PX4's events, without the component in the upper byte."""
MOST_OBJECTIONS = 8


class FenceService:
    """Fulfils `store_port.AutopilotFence`, and is a service of the vehicle.

    Args:
        wire: whose system the autopilot belongs to.
        telemetry: what it says.
        own: the fences that this companion has written.
    """

    wanted = frozenset({*TRANSFER_MESSAGES, "HOME_POSITION", "STATUSTEXT", "EVENT"})
    needs_control = True

    def __init__(self, wire: Wire, telemetry: Telemetry, own: OwnItems) -> None:
        self._store = PlanStore(wire, telemetry, FENCE, own)
        self._telemetry, self._own = telemetry, own
        self._home: tuple[float, float] | None = None
        self._objections: list[str] = []

    # -- store_port.AutopilotFence -------------------------------------------------------------

    @property
    def stored(self) -> StoredFence | None:
        """What was read last; None before, and where it is not known where it lies."""
        items = self._store.items
        return None if items is None else self._fence(items)

    @property
    def outcome(self) -> Outcome:
        """What has become of the last `read` or `write`."""
        return self._store.outcome

    @property
    def home(self) -> NorthEast | None:
        """The autopilot's home in the mission's frame; None where that is not known."""
        return None if self._home is None else self._telemetry.frame.from_earth(*self._home)

    @property
    def objections(self) -> Sequence[str]:
        """What the autopilot has said, since the last `write`, of areas that it leaves out."""
        return tuple(self._objections)

    def locate(self) -> Outcome:
        """Asks where the autopilot's frame lies on the earth."""
        return self._store.locate()

    def read(self) -> None:
        """Begins to ask for the fence."""
        self._store.read("the autopilot does not tell its fence")

    def write(self, areas: Sequence[FenceArea]) -> None:
        """Begins to put a fence in the place of the one that is there; rule 2."""
        on_earth = self._telemetry.frame.on_earth
        items = items_of(areas, on_earth)
        if items is not None and items == self._store.items:
            items = items_of(areas, on_earth, first=1)
        self._objections = []
        points = "" if items is None else f" of {len(items)} points"
        self._store.write(items, f"the autopilot does not take a fence{points}")

    def is_as_written(self) -> bool:
        """Whether what was read last is what was written last, wherever the frame is by now."""
        return self._store.is_as_written()

    def is_own(self) -> bool:
        """Whether what was read last was written by this companion, now or in another flight."""
        return any(self._is_like_read(items) for items in self._own.written)

    def is_vouched_for(self) -> bool:
        """Whether what was read last is known to be in force."""
        items = self._store.items
        return items is not None and items == self._own.in_force

    def vouch(self) -> None:
        """What was written last was read back, and nothing was said against it."""
        self._own.in_force = self._store.written

    def _fence(self, items: Sequence[PlanItem]) -> StoredFence | None:
        return fence_of(items, self._telemetry.frame.from_earth)

    def _is_like_read(self, items: UploadedItems) -> bool:
        ours, theirs = self._fence(items), self.stored
        if ours is None or theirs is None or theirs.flaw is not None:
            return False
        return are_alike(ours.areas, theirs.areas, ALIKE_M)

    # -- services.Service ----------------------------------------------------------------------

    def step(self, moment: Moment) -> None:
        """Time has passed."""
        self._store.step(moment)

    def take(self, moment: Moment, message: Message) -> None:
        """Takes what the autopilot says of its plans, its home, and what is wrong."""
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
            case _:
                self._store.take(moment, message)

    def due(self, moment: Moment) -> list[Message]:
        """What has to be said now."""
        return self._store.due(moment)

    def release(self) -> None:
        """Asks for nothing any longer."""
        self._store.forget()
        self._objections = []

    def _object(self, text: str) -> None:
        if text not in self._objections and len(self._objections) < MOST_OBJECTIONS:
            self._objections.append(text)
