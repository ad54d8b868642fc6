"""Reads and writes what an autopilot stores by the mission protocol, one kind of items. No I/O.

1. Transfers happen only while the vehicle stands disarmed, by what was heard last. When it is armed
   or in the air nothing is sent, and a transfer under way fails.
2. Stored items have positions on the earth. Without GLOBAL_POSITION_INT and GPS_GLOBAL_ORIGIN these
   cannot be converted, so nothing is read or written.
"""

from __future__ import annotations

import math

from companion.mavlink.framing import Message, source
from companion.mavlink.item_transfer import (
    TRANSFER_MESSAGES,
    ItemTransfer,
    StoredItem,
    TransferState,
)
from companion.outcomes import Failed, Outcome, Progress
from companion.vehicle.own_uploads import OwnItems, UploadedItems
from companion.vehicle.services import Moment
from companion.vehicle.telemetry import Telemetry
from companion.vehicle.wire import AUTOPILOT, COMPONENT, Wire

GLOBAL_POSITION_S = 1.0
"""A vehicle that has not reported a global position for this long has none."""
LOCATE_S = 10.0
ROUNDED, ROUNDED_M = 2, 0.01
"""How much the autopilot's number format may change a latitude, in 1e-7 degrees, and a height."""
TURN = 3_600_000_000
"""Once around the earth, in 1e-7 degrees of longitude."""


class ItemStore:
    """The items of one kind; the part that a fence and rally points share (`services.Service`).

    Args:
        wire: of the system that the autopilot belongs to.
        telemetry: of the autopilot.
        kind: MAV_MISSION_TYPE.
        own: items of that kind that this companion has written.
        name: of the items in failure messages, as in "the autopilot does not report its fence".

    Attributes:
        items: the items read last; None before.
        written: the items written last in this flight; None before.
    """

    wanted = TRANSFER_MESSAGES
    needs_control = True

    def __init__(
        self, wire: Wire, telemetry: Telemetry, kind: int, own: OwnItems, name: str
    ) -> None:
        self._wire, self._telemetry = wire, telemetry
        self._kind, self._own, self._name = kind, own, name
        self._forget()

    def _forget(self) -> None:
        self.items: UploadedItems | None = None
        self.written: UploadedItems | None = None
        self._transfer: ItemTransfer | None = None
        self._purpose, self._is_reading = "", False
        self._refusal: Failed | None = None
        self._leaving: list[Message] = []
        self._located_from_s: float | None = None
        self._heard_s = 0.0

    @property
    def outcome(self) -> Outcome:
        """What became of the last `read` or `write`."""
        transfer = self._transfer
        if self._refusal is not None:
            return self._refusal
        if transfer is None or transfer.is_under_way:
            return Progress.RUNNING
        if transfer.failure is not None:
            return Failed(f"{self._purpose}: {transfer.failure.reason}")
        return Progress.DONE

    @property
    def is_writing(self) -> bool:
        """Whether items are being written."""
        transfer = self._transfer
        return transfer is not None and transfer.is_under_way and not self._is_reading

    def locate(self) -> Outcome:
        """Asks where the autopilot's frame lies on the earth."""
        if self._telemetry.placed.location is not None:
            return Progress.DONE
        if self._located_from_s is None:
            self._located_from_s = self._heard_s
        waited_s = self._heard_s - self._located_from_s
        if self._telemetry.placed.origins.altitude_m is None and waited_s > GLOBAL_POSITION_S:
            return Failed("the autopilot reports no position on the earth")
        if waited_s > LOCATE_S:
            return Failed("the autopilot does not say where its local frame lies on the earth")
        return Progress.RUNNING

    def read(self) -> None:
        """Begins to read the items."""
        self.items = None
        self._begin(f"the autopilot does not report its {self._name}", None)

    def _write(self, items: UploadedItems | None, purpose: str) -> None:
        """Begins to replace the stored items.

        Args:
            items: None if their position on the earth is not known.
            purpose: the sentence that begins the failure message.
        """
        if items is None:
            self._refuse(f"{purpose}: it is not known where on the earth that lies")
            return
        self._own.note(items)
        self.written = items
        self._begin(purpose, items)

    def _refuse(self, reason: str) -> None:
        """Writes nothing, and says why as the outcome."""
        self._refusal = Failed(reason)

    def is_as_written(self) -> bool:
        """Whether the items read last are those written last.

        They are compared by position on the earth. The mission's frame may have moved since: it
        settles while the vehicle stands, and what the vehicle sees of its walls moves it.
        """
        ours, theirs = self.written, self.items
        if ours is None or theirs is None or len(ours) != len(theirs):
            return False
        return all(map(_is_same, ours, theirs))

    def _begin(self, purpose: str, items: UploadedItems | None) -> None:
        target, own = (self._wire.system, AUTOPILOT), (self._wire.system, COMPONENT)
        self._purpose, self._is_reading = purpose, items is None
        self._refusal = None
        self._transfer = ItemTransfer(self._heard_s, target, own, self._kind, items)

    def step(self, moment: Moment) -> None:
        """Notes the time; applies rule 1."""
        self._heard_s = moment.heard_s
        if self._telemetry.is_flown and self._transfer is not None:
            self._transfer = None
            self._refuse(f"{self._purpose}: the vehicle is armed or in the air")

    def take(self, moment: Moment, message: Message) -> None:
        """Takes one of TRANSFER_MESSAGES; only those of the autopilot count."""
        if self._transfer is not None and source(message)[1] == AUTOPILOT:
            self._leaving += self._transfer.take(moment.heard_s, message)
            if self._is_reading and self._transfer.state is TransferState.DONE:
                self.items = tuple(self._transfer.items)

    def due(self, moment: Moment) -> list[Message]:
        """What the transfer has to send now, and the request for the frame's origin."""
        leaving, self._leaving = self._leaving, []
        if moment.is_quiet or self._telemetry.is_flown:
            return []
        if self._transfer is not None:
            leaving += self._transfer.due(moment.heard_s)
        origins = self._telemetry.placed.origins
        is_asked = self._located_from_s is not None and self._telemetry.placed.location is None
        if is_asked and origins.altitude_m is not None:
            leaving += origins.due(moment.now_s, (self._wire.system, AUTOPILOT), is_needed=True)
        return leaving

    def release(self) -> None:
        """Drops the transfer and everything that was read."""
        self._forget()


def _is_same(one: StoredItem, other: StoredItem) -> bool:
    kinds = (one.command, one.frame, one.first), (other.command, other.frame, other.first)
    apart = max(abs(one.x - other.x), abs(math.remainder(one.y - other.y, TURN)))
    return (
        kinds[0] == kinds[1]
        and apart <= ROUNDED
        and abs(one.altitude_m - other.altitude_m) <= ROUNDED_M
    )
