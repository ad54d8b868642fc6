"""The mission protocol, vehicle's side: missions, geofences and rally points.

No I/O: messages in, addressed messages out, time is an argument. There are three stores, one for
each MAV_MISSION_TYPE. Rules:

1. Upload: after MISSION_COUNT, the service requests each item by MISSION_REQUEST_INT, and again
   every 250 ms. (It never sends the float MISSION_REQUEST, but accepts MISSION_ITEM.) With the last
   item the store changes, at once and as a whole; before, it does not change.
2. Only one upload at a time. Others get MISSION_ACK ERROR meanwhile. After 5 s of silence it ends
   with OPERATION_CANCELLED.
3. An item that is not the next one is ignored; the next one is requested again anyway. An item
   beyond the count, or one that the autopilot does not accept, ends the upload.
4. If the last item arrives again, its acknowledgement was lost: it is acknowledged again.
5. Download: MISSION_REQUEST_LIST copies the store. Its items are sent in any order until the client
   acknowledges, or is silent for 5 s. Without a copy, requests are ignored. A download affects only
   its own client, which cannot upload meanwhile.
6. Equal items change neither a store nor the flight of a mission.

    upload      MISSION_COUNT                        an item
    none        receiving                            MISSION_ACK ERROR
    receiving   receiving from the same client that  the next one is requested; after the last one
                has sent no item yet, else ERROR     accepted; a bad one: none (rule 3)
    accepted    receiving                            the last one again: ACCEPTED again (rule 4)

MISSION_CLEAR_ALL leads to `none`. While receiving, so do silence and a client that gives up.

Sources: https://mavlink.io/en/services/mission.html; PX4 1.16, src/modules/mavlink/
mavlink_mission.cpp, and observed answers of PX4. Left out: the numbers of plans in answers
(MISSION_CURRENT has them); partial lists, which PX4 does not serve either.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ClassVar

from companion.mavlink.framing import Message, dialect, source
from sitl.link.mission_items import (
    MissionType,
    WireItem,
    check_item,
    float_message,
    int_message,
    wire_item,
)
from sitl.link.routing import LinkName

MOST_ITEMS = {MissionType.MISSION: 500, MissionType.FENCE: 64, MissionType.RALLY: 32}
"""Most items of a plan; for fence and rally points as in PX4."""
MOST_DOWNLOADS = 16  # at a time; a further one replaces the oldest
REQUEST_AGAIN_S = 0.25
SILENT_S = 5.0
ALL_KINDS = 255  # MAV_MISSION_TYPE_ALL

Address = tuple[int, int]
Items = tuple[WireItem, ...]
AcceptPlan = Callable[[MissionType, Items, int | None], None]
"""Hands a new plan to the autopilot, with the item marked as current."""


@dataclass(slots=True)
class MissionUpload:
    """An upload under way; `link` is where its client is."""

    link: LinkName
    client: Address
    kind: MissionType
    count: int
    heard_s: float
    asked_s: float
    items: list[WireItem] = field(default_factory=list)
    current: int | None = None

    def request(self) -> Message:
        """Requests the next item."""
        seq = len(self.items)
        return dialect.MAVLink_mission_request_int_message(*self.client, seq, self.kind)


@dataclass(frozen=True, slots=True)
class AcceptedUpload:
    """The last completed upload, with its last item."""

    client: Address
    kind: MissionType
    last_seq: int


@dataclass(slots=True)
class MissionDownload:
    """A copy of a store, for one client."""

    kind: MissionType
    items: Items
    heard_s: float


class MissionService:
    """The stores, and the transfers under way.

    Args:
        accept: called with each new plan.
        current: index of the mission's current item.
    """

    def __init__(self, accept: AcceptPlan, current: Callable[[], int]) -> None:
        self._accept = accept
        self._current = current
        self._stores: dict[MissionType, Items] = {kind: () for kind in MissionType}
        self._upload: MissionUpload | AcceptedUpload | None = None
        self._downloads: dict[Address, MissionDownload] = {}

    def items(self, kind: MissionType) -> Items:
        """The items in a store."""
        return self._stores[kind]

    @property
    def is_busy(self) -> bool:
        """Whether an upload is under way."""
        return isinstance(self._upload, MissionUpload)

    def receive(self, link: LinkName, message: Message, now_s: float) -> list[Message]:
        """Handles a message of the protocol; the answers go back to its link."""
        handle = self.HANDLERS.get(message.get_type())
        return handle(self, link, message, now_s) if handle else []

    def due(self, now_s: float) -> list[tuple[LinkName, Message]]:
        """The messages that are due by time."""
        if self._downloads:
            for client in [c for c, d in self._downloads.items() if now_s - d.heard_s > SILENT_S]:
                del self._downloads[client]
        upload = self._upload
        if not isinstance(upload, MissionUpload):
            return []
        if now_s - upload.heard_s > SILENT_S:
            self._upload = None
            end = _ack(upload.client, dialect.MAV_MISSION_OPERATION_CANCELLED, upload.kind)
            return [(upload.link, end)]
        if now_s - upload.asked_s < REQUEST_AGAIN_S:
            return []
        upload.asked_s = now_s
        return [(upload.link, upload.request())]

    # Uploads.

    def _count(self, link: LinkName, message: Message, now_s: float) -> list[Message]:
        client, kind, count = source(message), _kind(message), message.count
        upload = self._upload
        if kind is None:
            return [_ack(client, dialect.MAV_MISSION_UNSUPPORTED, message.mission_type)]
        if client in self._downloads:
            return [_ack(client, dialect.MAV_MISSION_ERROR, kind)]
        if isinstance(upload, MissionUpload):
            if upload.client != client or upload.items:
                return [_ack(client, dialect.MAV_MISSION_ERROR, kind)]
            self._upload = None
        if count > MOST_ITEMS[kind]:
            return [_ack(client, dialect.MAV_MISSION_NO_SPACE, kind)]
        if count == 0:
            self._replace(kind, (), None)
            return [_ack(client, dialect.MAV_MISSION_ACCEPTED, kind)]
        self._upload = upload = MissionUpload(link, client, kind, count, now_s, now_s)
        return [upload.request()]

    def _item(self, link: LinkName, message: Message, now_s: float) -> list[Message]:
        client, upload = source(message), self._upload
        if not isinstance(upload, MissionUpload) or upload.client != client:
            kind = _kind(message)
            is_again = kind is not None and upload == AcceptedUpload(client, kind, message.seq)
            result = dialect.MAV_MISSION_ACCEPTED if is_again else dialect.MAV_MISSION_ERROR
            return [_ack(client, result, message.mission_type)]
        if message.mission_type != upload.kind:
            return [_ack(client, dialect.MAV_MISSION_ERROR, upload.kind)]
        upload.heard_s = now_s
        if message.seq >= upload.count:
            return self._finish(upload, dialect.MAV_MISSION_INVALID_SEQUENCE)
        if message.seq != len(upload.items):
            return []
        item = wire_item(message)
        if result := check_item(upload.kind, item):
            return self._finish(upload, result)
        upload.items.append(item)
        if message.current:
            upload.current = message.seq
        if len(upload.items) < upload.count:
            upload.asked_s = now_s
            return [upload.request()]
        self._replace(upload.kind, tuple(upload.items), upload.current)
        return self._finish(upload, dialect.MAV_MISSION_ACCEPTED)

    def _finish(self, upload: MissionUpload, result: int) -> list[Message]:
        is_accepted = result == dialect.MAV_MISSION_ACCEPTED
        last_seq = upload.count - 1
        self._upload = AcceptedUpload(upload.client, upload.kind, last_seq) if is_accepted else None
        return [_ack(upload.client, result, upload.kind)]

    def _replace(self, kind: MissionType, items: Items, current: int | None) -> None:
        """Changes a store, by rule 6."""
        if items != self._stores[kind]:
            self._stores[kind] = items
            self._accept(kind, items, current)

    def _clear(self, link: LinkName, message: Message, now_s: float) -> list[Message]:
        client, kind = source(message), _kind(message)
        if kind is None and message.mission_type != ALL_KINDS:
            return [_ack(client, dialect.MAV_MISSION_UNSUPPORTED, message.mission_type)]
        if self.is_busy:
            return [_ack(client, dialect.MAV_MISSION_ERROR, message.mission_type)]
        for each in MissionType if kind is None else (kind,):
            self._replace(each, (), None)
        self._upload = None
        return [_ack(client, dialect.MAV_MISSION_ACCEPTED, message.mission_type)]

    # Downloads.

    def _list(self, link: LinkName, message: Message, now_s: float) -> list[Message]:
        client, kind = source(message), _kind(message)
        if kind is None:
            return [_ack(client, dialect.MAV_MISSION_UNSUPPORTED, message.mission_type)]
        self._downloads.pop(client, None)
        if len(self._downloads) >= MOST_DOWNLOADS:
            del self._downloads[next(iter(self._downloads))]
        items = self._stores[kind]
        self._downloads[client] = MissionDownload(kind, items, now_s)
        return [dialect.MAVLink_mission_count_message(*client, len(items), kind)]

    def _request(self, link: LinkName, message: Message, now_s: float) -> list[Message]:
        client = source(message)
        download = self._downloads.get(client)
        if download is None or download.kind != message.mission_type:
            return []
        download.heard_s = now_s
        if message.seq >= len(download.items):
            del self._downloads[client]
            return [_ack(client, dialect.MAV_MISSION_INVALID_SEQUENCE, download.kind)]
        is_current = download.kind is MissionType.MISSION and message.seq == self._current()
        make = int_message if message.get_type() == "MISSION_REQUEST_INT" else float_message
        item = download.items[message.seq]
        return [make(item, message.seq, client, download.kind, is_current)]

    def _acknowledged(self, link: LinkName, message: Message, now_s: float) -> list[Message]:
        """Handles the end of a download, or of an upload that its client gives up."""
        client, upload = source(message), self._upload
        download = self._downloads.get(client)
        if download and download.kind == message.mission_type:
            del self._downloads[client]
        elif (
            isinstance(upload, MissionUpload)
            and upload.client == client
            and message.type != dialect.MAV_MISSION_ACCEPTED
        ):
            self._upload = None
        return []

    HANDLERS: ClassVar[
        dict[str, Callable[[MissionService, LinkName, Message, float], list[Message]]]
    ] = {
        "MISSION_COUNT": _count,
        "MISSION_ITEM_INT": _item,
        "MISSION_ITEM": _item,
        "MISSION_CLEAR_ALL": _clear,
        "MISSION_REQUEST_LIST": _list,
        "MISSION_REQUEST_INT": _request,
        "MISSION_REQUEST": _request,
        "MISSION_ACK": _acknowledged,
    }
    """Message -> its handler."""


def _kind(message: Message) -> MissionType | None:
    known = message.mission_type in MissionType.__members__.values()
    return MissionType(message.mission_type) if known else None


def _ack(client: Address, result: int, mission_type: int) -> Message:
    return dialect.MAVLink_mission_ack_message(*client, result, mission_type)
