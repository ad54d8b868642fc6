"""The fence of the autopilot over MAVLink: read, written, and what is said of it. No I/O.

1. It is read and written while the vehicle stands disarmed, by what was heard last. Once it is
   armed or in the air nothing is said, and a transfer has failed.
2. A fence lies on the earth: without GLOBAL_POSITION_INT and GPS_GLOBAL_ORIGIN it is not known
   where, and none is read or written.
3. PX4 takes every fence, reads it back whole, and then leaves out an area that does not hold its
   home. It says so by an event, and where a ground station is heard by a text; both are heard here.
4. PX4 does not load equal items anew; a fence that is written again begins with another corner.

Source: https://mavlink.io/en/services/mission.html; PX4 1.16, src/modules/navigator/geofence.cpp.
"""

from __future__ import annotations

from collections.abc import Sequence

from companion.geofence import FenceArea, StoredFence, are_alike
from companion.geometry import NorthEast
from companion.mavlink.framing import Message, dialect, source
from companion.mavlink.plan_transfer import (
    TRANSFER_MESSAGES,
    PlanItem,
    PlanTransfer,
    TransferState,
)
from companion.vehicle.fence_items import fence_of, items_of
from companion.vehicle.own_fences import FenceItems, OwnFences
from companion.vehicle.port import Failed, Outcome, Progress
from companion.vehicle.services import Moment
from companion.vehicle.telemetry import Telemetry
from companion.vehicle.wire import AUTOPILOT, COMPONENT, Wire

FENCE = dialect.MAV_MISSION_TYPE_FENCE
ALIKE_M = 0.2
"""Corners that are nearer to each other are the same."""
GLOBAL_POSITION_S = 1.0
"""A vehicle that has told none for so long has none."""
LOCATE_S = 10.0
OBJECTION = "Geofence invalid"
OBJECTIONS = {
    10973461: "Geofence invalid, doesn't contain Home position",
    9432105: "Geofence invalid, doesn't contain current vehicle position",
}
"""Numbers of PX4's events, without the component in the upper byte."""
MOST_OBJECTIONS = 8


class FenceService:
    """Fulfils `port.AutopilotFence`, and is a service of the vehicle.

    Args:
        wire: whose system the autopilot belongs to.
        telemetry: what it says.
        own: the fences that this companion has written.
    """

    wanted = frozenset({*TRANSFER_MESSAGES, "HOME_POSITION", "STATUSTEXT", "EVENT"})
    needs_control = True

    def __init__(self, wire: Wire, telemetry: Telemetry, own: OwnFences) -> None:
        self._wire, self._telemetry, self._own = wire, telemetry, own
        self._home: tuple[float, float] | None = None
        self._forget()

    def _forget(self) -> None:
        self._transfer: PlanTransfer | None = None
        self._purpose, self._is_reading = "", False
        self._refusal: Failed | None = None
        self._read: FenceItems | None = None
        self._written: FenceItems | None = None
        self._objections: list[str] = []
        self._leaving: list[Message] = []
        self._located_from_s: float | None = None
        self._heard_s = 0.0

    # -- port.AutopilotFence -------------------------------------------------------------------

    @property
    def stored(self) -> StoredFence | None:
        """What was read last; None before, and where it is not known where it lies."""
        return None if self._read is None else self._fence(self._read)

    @property
    def outcome(self) -> Outcome:
        """What has become of the last `read` or `write`."""
        transfer = self._transfer
        if self._refusal is not None:
            return self._refusal
        if transfer is None or transfer.is_under_way:
            return Progress.RUNNING
        if transfer.failure is not None:
            return Failed(f"{self._purpose}: {transfer.failure.reason}")
        return Progress.DONE

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
        if self._telemetry.location is not None:
            return Progress.DONE
        if self._located_from_s is None:
            self._located_from_s = self._heard_s
        waited_s = self._heard_s - self._located_from_s
        if self._telemetry.origins.altitude_m is None and waited_s > GLOBAL_POSITION_S:
            return Failed("the autopilot tells no position on the earth")
        if waited_s > LOCATE_S:
            return Failed("the autopilot does not say where its local frame lies on the earth")
        return Progress.RUNNING

    def read(self) -> None:
        """Begins to ask for the fence."""
        self._read = None
        self._begin("the autopilot does not tell its fence", None)

    def write(self, areas: Sequence[FenceArea]) -> None:
        """Begins to put a fence in the place of the one that is there; rule 4."""
        on_earth = self._telemetry.frame.on_earth
        items = items_of(areas, on_earth)
        if items is not None and items == self._read:
            items = items_of(areas, on_earth, first=1)
        if items is None:
            self._refusal = Failed("it is not known where on the earth the fence lies")
            return
        self._own.note(items)
        self._written, self._objections = items, []
        self._begin(f"the autopilot does not take a fence of {len(items)} points", items)

    def is_own(self) -> bool:
        """Whether what was read last was written by this companion, now or in another flight."""
        return any(self._is_like_read(items) for items in self._own.written)

    def is_vouched_for(self) -> bool:
        """Whether what was read last is known to be in force."""
        return self._read is not None and self._read == self._own.in_force

    def vouch(self) -> None:
        """What was written last was read back, and nothing was said against it."""
        self._own.in_force = self._written

    def _begin(self, purpose: str, items: FenceItems | None) -> None:
        target, own = (self._wire.system, AUTOPILOT), (self._wire.system, COMPONENT)
        self._purpose, self._is_reading = purpose, items is None
        self._refusal = None
        self._transfer = PlanTransfer(self._heard_s, target, own, FENCE, items)

    def _fence(self, items: Sequence[PlanItem]) -> StoredFence | None:
        return fence_of(items, self._telemetry.frame.from_earth)

    def _is_like_read(self, items: FenceItems) -> bool:
        ours, theirs = self._fence(items), self.stored
        if ours is None or theirs is None or theirs.flaw is not None:
            return False
        return are_alike(ours.areas, theirs.areas, ALIKE_M)

    # -- services.Service ----------------------------------------------------------------------

    def step(self, moment: Moment) -> None:
        """Time has passed; rule 1."""
        self._heard_s = moment.heard_s
        if self._telemetry.is_flown and self._transfer is not None:
            self._transfer = None
            self._refusal = Failed(f"{self._purpose}: the vehicle is armed or in the air")

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
            case _ if self._transfer is not None:
                self._leaving += self._transfer.take(moment.heard_s, message)
                if self._is_reading and self._transfer.state is TransferState.DONE:
                    self._read = tuple(self._transfer.items)

    def due(self, moment: Moment) -> list[Message]:
        """What the transfer has to say now, and the question where the frame lies."""
        leaving, self._leaving = self._leaving, []
        if moment.is_quiet or self._telemetry.is_flown:
            return []
        if self._transfer is not None:
            leaving += self._transfer.due(moment.heard_s)
        origins = self._telemetry.origins
        is_asked = self._located_from_s is not None and self._telemetry.location is None
        if is_asked and origins.altitude_m is not None:
            leaving += origins.due(moment.now_s, (self._wire.system, AUTOPILOT), is_needed=True)
        return leaving

    def release(self) -> None:
        """Asks for nothing any longer."""
        self._forget()

    def _object(self, text: str) -> None:
        if text not in self._objections and len(self._objections) < MOST_OBJECTIONS:
            self._objections.append(text)
