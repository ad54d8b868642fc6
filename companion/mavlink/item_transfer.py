"""The client's side of the mission protocol: reads or writes a plan of an autopilot. No I/O.

A plan is a list of items of one MAV_MISSION_TYPE: a mission, a fence or rally points. A transfer is
a state machine: messages and time in, messages out. Its duration is bounded, and no answer raises
an exception.

1. The client sends MISSION_REQUEST_LIST or MISSION_COUNT, and repeats it every ASK_AGAIN_S until it
   is answered.
2. Reading: the client requests one item after the other with MISSION_REQUEST_INT, and repeats each
   request every ITEM_AGAIN_S. It acknowledges the last item.
3. Writing: the autopilot requests the items, again if one is lost. If the autopilot's
   acknowledgement is lost, the client repeats the item that was requested last; PX4 then
   acknowledges again.
4. An autopilot that is busy with somebody else, or gives up a transfer, answers MISSION_ACK with an
   error. The client then starts over. An autopilot that is busy with this very upload, as when
   MISSION_COUNT came twice, requests the remaining items; its earlier requests count.
5. SILENT_S without an answer in this transfer, LONGEST_S in all, or a refusal is a failure.

    asking       answered                    -> reading, or writing
    reading      the last item has come      -> done;  an error -> asking
    writing      accepted, with all items    -> done;  an error -> asking
    any of them  refused, or silence         -> failed

Sources: https://mavlink.io/en/services/mission.html; PX4 1.16, src/modules/mavlink/
mavlink_mission.cpp.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from companion.mavlink.framing import Message, dialect
from companion.outcomes import Refusal

ASK_AGAIN_S = 1.0
ITEM_AGAIN_S = 0.25
SILENT_S = 10.0
LONGEST_S = 60.0
MOST_ITEMS = 500
"""A longer plan is not read."""

TRANSFER_MESSAGES = frozenset(
    {"MISSION_COUNT", "MISSION_ITEM_INT", "MISSION_REQUEST_INT", "MISSION_REQUEST", "MISSION_ACK"}
)
"""The messages of an autopilot in a transfer."""

_ACCEPTED = dialect.MAV_MISSION_ACCEPTED
_BUSY = (dialect.MAV_MISSION_ERROR, dialect.MAV_MISSION_OPERATION_CANCELLED)
"""Results after which the client starts over; PX4 sends ERROR when it is busy."""

_PLAIN_FRAMES = {
    dialect.MAV_FRAME_GLOBAL_INT: dialect.MAV_FRAME_GLOBAL,
    dialect.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT: dialect.MAV_FRAME_GLOBAL_RELATIVE_ALT,
}
"""PX4 returns the frame numbers for integers, whichever were written."""

Address = tuple[int, int]
"""System and component."""


@dataclass(frozen=True, slots=True)
class StoredItem:
    """One item of a plan, as it is transferred.

    Attributes:
        command: MAV_CMD number.
        frame: MAV_FRAME number; of equivalent ones, the one without `_INT`.
        first: param1; the other three are 0.
        x: latitude in 1e-7 degrees.
        y: longitude in 1e-7 degrees.
        altitude_m: above home or above the sea, by the frame.
    """

    command: int
    frame: int
    first: float
    x: int
    y: int
    altitude_m: float = 0.0


class TransferState(Enum):
    """The states of a transfer."""

    ASKING = "asking"
    READING = "reading"
    WRITING = "writing"
    DONE = "done"
    FAILED = "failed"


class ItemTransfer:
    """Reads or writes one plan.

    Args:
        now_s: when it begins.
        target: address of the autopilot.
        own: our address; messages to others are ignored.
        kind: MAV_MISSION_TYPE.
        items: to write; None to read.

    Attributes:
        state: the present state.
        failure: why it has failed; None unless it has.
        items: those read so far, or those to write.
    """

    def __init__(
        self,
        now_s: float,
        target: Address,
        own: Address,
        kind: int,
        items: Sequence[StoredItem] | None = None,
    ) -> None:
        self.state = TransferState.ASKING
        self.failure: Refusal | None = None
        self.items: list[StoredItem] = list(items or ())
        self._is_writing = items is not None
        self._target, self._own, self._kind = target, own, kind
        self._start_s = self._heard_s = now_s
        self._next_s = -math.inf
        self._count = len(self.items)
        self._asked: set[int] = set()  # writing: the items that were requested
        self._newest = 0

    @property
    def is_under_way(self) -> bool:
        """Whether it is neither done nor failed."""
        return self.state not in (TransferState.DONE, TransferState.FAILED)

    def take(self, now_s: float, message: Message) -> list[Message]:
        """Takes one of the autopilot's TRANSFER_MESSAGES; returns the answers to send at once."""
        is_ours = (message.target_system, message.target_component) == self._own
        if not (is_ours and message.mission_type == self._kind and self.is_under_way):
            return []
        match message.get_type():
            case "MISSION_ACK":
                return self._take_ack(now_s, message)
            case "MISSION_COUNT" if not self._is_writing and self.state is TransferState.ASKING:
                return self._take_count(now_s, message)
            case "MISSION_ITEM_INT" if self.state is TransferState.READING:
                return self._take_item(now_s, message)
            case "MISSION_REQUEST_INT" | "MISSION_REQUEST" if self._is_writing:
                return self._take_request(now_s, message)
        return []

    def due(self, now_s: float) -> list[Message]:
        """The messages to send now because no answer has come."""
        if not self.is_under_way or self._is_out_of_time(now_s) or now_s < self._next_s:
            return []
        self._next_s = now_s + (
            ASK_AGAIN_S if self.state is TransferState.ASKING else 2 * ITEM_AGAIN_S
        )
        match self.state:
            case TransferState.READING:
                return [self._request(now_s)]
            case TransferState.WRITING:
                return [self._item(self._newest)]
        if self._is_writing:
            return [dialect.MAVLink_mission_count_message(*self._target, self._count, self._kind)]
        return [dialect.MAVLink_mission_request_list_message(*self._target, self._kind)]

    def _is_out_of_time(self, now_s: float) -> bool:
        if (silent_s := now_s - self._heard_s) > SILENT_S:
            self._fail(f"no answer in {silent_s:.0f} s")
        elif now_s - self._start_s > LONGEST_S:
            self._fail(f"not done in {LONGEST_S:.0f} s")
        return not self.is_under_way

    # -- reading -------------------------------------------------------------------------------

    def _take_count(self, now_s: float, message: Message) -> list[Message]:
        if message.count > MOST_ITEMS:
            self._fail(f"a plan of {message.count} items")
            return []
        self._heard_s, self._count = now_s, message.count
        self.state = TransferState.READING
        return self._go_on(now_s)

    def _take_item(self, now_s: float, message: Message) -> list[Message]:
        if message.seq != len(self.items):
            return []
        self._heard_s = now_s
        frame = _PLAIN_FRAMES.get(message.frame, message.frame)
        item = StoredItem(
            message.command,
            frame,
            first=message.param1,
            x=message.x,
            y=message.y,
            altitude_m=message.z,
        )
        self.items.append(item)
        return self._go_on(now_s)

    def _go_on(self, now_s: float) -> list[Message]:
        """Requests the next item, or acknowledges the last one."""
        if len(self.items) < self._count:
            return [self._request(now_s)]
        self.state = TransferState.DONE
        return [dialect.MAVLink_mission_ack_message(*self._target, _ACCEPTED, self._kind)]

    def _request(self, now_s: float) -> Message:
        self._next_s = now_s + ITEM_AGAIN_S
        seq = len(self.items)
        return dialect.MAVLink_mission_request_int_message(*self._target, seq, self._kind)

    # -- writing -------------------------------------------------------------------------------

    def _take_request(self, now_s: float, message: Message) -> list[Message]:
        if message.seq >= self._count:
            return []
        self._heard_s, self.state = now_s, TransferState.WRITING
        self._next_s = now_s + 2 * ITEM_AGAIN_S
        self._newest = message.seq
        self._asked.add(message.seq)
        return [self._item(message.seq)]

    def _item(self, seq: int) -> Message:
        item = self.items[seq]
        return dialect.MAVLink_mission_item_int_message(
            *self._target,
            seq,
            item.frame,
            item.command,
            current=0,
            autocontinue=1,
            param1=item.first,
            param2=0.0,
            param3=0.0,
            param4=0.0,
            x=item.x,
            y=item.y,
            z=item.altitude_m,
            mission_type=self._kind,
        )

    # -- both ----------------------------------------------------------------------------------

    def _take_ack(self, now_s: float, message: Message) -> list[Message]:
        result = message.type
        if result == _ACCEPTED:
            if self._is_writing and len(self._asked) == self._count:
                self.state = TransferState.DONE
        elif result in _BUSY:
            self._heard_s = now_s
            self.state, self._next_s = TransferState.ASKING, now_s + ASK_AGAIN_S
            if not self._is_writing:
                self.items.clear()
        else:
            self._fail(f"the answer is {_result_name(result)}")
        return []

    def _fail(self, why: str) -> None:
        self.state, self.failure = TransferState.FAILED, Refusal(why)


def _result_name(result: int) -> str:
    """A MAV_MISSION_RESULT in words.

    >>> _result_name(4), _result_name(99)
    ('no space', '99')
    """
    entry = dialect.enums["MAV_MISSION_RESULT"].get(result)
    name = entry.name if entry is not None else str(result)
    return name.removeprefix("MAV_MISSION_").replace("_", " ").lower()
