"""Plans are read and written over links that lose, and whatever an autopilot answers."""

from __future__ import annotations

from random import Random
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.mavlink.framing import dialect
from companion.mavlink.item_transfer import (
    LONGEST_S,
    MOST_ITEMS,
    SILENT_S,
    TRANSFER_MESSAGES,
    ItemTransfer,
    StoredItem,
    TransferState,
)
from sitl.link.mission_service import MissionService
from sitl.link.routing import LinkName

AUTOPILOT, OWN, OTHER = (1, 1), (1, 191), (255, 190)
FENCE = dialect.MAV_MISSION_TYPE_FENCE
TICK_S = 0.05
ITEMS = [StoredItem(5001, 0, 8.0, 473977000 + i, 85455000 - i) for i in range(8)]
LINK = LinkName.OFFBOARD


class Peer:
    """The simulator's side of the protocol, over a link that loses a share each way.

    Shaken, each message comes up to 0.2 s late, so that they overtake each other; half come twice.
    """

    def __init__(self, share: float = 0.0, seed: int = 0, is_shaken: bool = False) -> None:
        self.service = MissionService(lambda kind, items, current: None, lambda: 0)
        self.now_s = 0.0
        self.sent = 0
        self._share, self._random, self._is_shaken = share, Random(seed), is_shaken
        self._late: dict[bool, list[tuple[float, Any]]] = {True: [], False: []}

    def says(self, message: Any, by: tuple[int, int] = OWN) -> list[Any]:
        message._header = dialect.MAVLink_header(0, srcSystem=by[0], srcComponent=by[1])
        return self.service.receive(LINK, message, self.now_s)

    def fly(self, transfer: ItemTransfer) -> ItemTransfer:
        coming: list[Any] = []
        while transfer.is_under_way:
            self.now_s += TICK_S
            leaving = [m for c in coming for m in transfer.take(self.now_s, c)]
            leaving += transfer.due(self.now_s)
            self.sent += len(leaving)
            answers = [answer for m in self._through(leaving, True) for answer in self.says(m)]
            answers += [message for _, message in self.service.due(self.now_s)]
            coming = self._through(answers, False)
        return transfer

    def _through(self, messages: list[Any], is_up: bool) -> list[Any]:
        through = [m for m in messages if self._random.random() >= self._share]
        if not self._is_shaken:
            return through
        twice = [m for m in through if self._random.random() < 0.5]
        late = self._late[is_up]
        late += [(self.now_s + self._random.uniform(0.0, 0.2), m) for m in through + twice]
        self._late[is_up] = [(s, m) for s, m in late if s > self.now_s]
        return [m for s, m in sorted(late, key=lambda each: each[0]) if s <= self.now_s]

    def write(self) -> ItemTransfer:
        return self.fly(ItemTransfer(self.now_s, AUTOPILOT, OWN, FENCE, ITEMS))

    def read(self) -> ItemTransfer:
        return self.fly(ItemTransfer(self.now_s, AUTOPILOT, OWN, FENCE))


@pytest.mark.parametrize(("share", "within_s"), [(0.0, 1.0), (0.3, 20.0)])
@pytest.mark.parametrize("seed", range(8))
def test_what_is_written_is_read_back(share: float, within_s: float, seed: int) -> None:
    peer = Peer(share, seed)
    assert peer.write().state is TransferState.DONE
    written_s = peer.now_s
    back = peer.read()
    assert back.state is TransferState.DONE
    assert back.items == ITEMS
    assert written_s <= within_s and peer.now_s - written_s <= within_s
    assert peer.sent <= 400


@pytest.mark.parametrize("share", [0.0, 0.1])
@pytest.mark.parametrize("seed", [*range(20), 166, 325, 360])
def test_so_it_is_where_messages_overtake_each_other_and_come_twice(
    share: float, seed: int
) -> None:
    """A second MISSION_COUNT meets an autopilot that is busy with the first: that says ERROR."""
    peer = Peer(share, seed, is_shaken=True)
    assert peer.write().state is TransferState.DONE
    back = peer.read()
    assert (back.state, back.items) == (TransferState.DONE, ITEMS)


def test_an_autopilot_without_a_plan_has_an_empty_one() -> None:
    back = Peer().read()
    assert (back.state, back.items) == (TransferState.DONE, [])


def test_silence_is_a_failure() -> None:
    peer = Peer(share=1.0)
    back = peer.read()
    assert back.state is TransferState.FAILED and back.failure is not None
    assert back.failure.reason == "no answer in 10 s"
    assert peer.now_s == pytest.approx(SILENT_S, abs=0.1)


def test_one_that_is_busy_is_asked_again() -> None:
    peer = Peer()
    peer.says(dialect.MAVLink_mission_count_message(*AUTOPILOT, 3, FENCE), by=OTHER)
    assert peer.service.is_busy
    assert peer.write().state is TransferState.DONE  # after the other one was silent for 5 s
    assert 5.0 < peer.now_s < 8.0


def test_one_that_is_busy_for_a_minute_is_asked_no_longer() -> None:
    """To be busy is an answer, so that is no silence."""
    transfer = ItemTransfer(0.0, AUTOPILOT, OWN, FENCE, ITEMS)
    busy = dialect.MAVLink_mission_ack_message(*OWN, dialect.MAV_MISSION_ERROR, FENCE)
    for tick in range(round((LONGEST_S + 1) / TICK_S)):
        transfer.due(tick * TICK_S)
        transfer.take(tick * TICK_S, busy)
    assert transfer.failure is not None and transfer.failure.reason == "not done in 60 s"


def test_a_download_is_ended_so_that_an_upload_can_begin() -> None:
    """An empty one, too: PX4 is busy with it until it is acknowledged, or for five seconds."""
    peer = Peer()
    assert peer.read().items == []
    start_s = peer.now_s
    assert peer.write().state is TransferState.DONE
    assert peer.now_s - start_s < 1.0


def test_what_is_too_much_is_refused() -> None:
    peer = Peer()
    transfer = peer.fly(ItemTransfer(0.0, AUTOPILOT, OWN, FENCE, ITEMS * 9))
    assert transfer.failure is not None and transfer.failure.reason == "the answer is no space"


def answers(transfer: ItemTransfer, *messages: Any) -> list[Any]:
    transfer.due(0.0)
    return [answer for message in messages for answer in transfer.take(0.1, message)]


def test_a_plan_without_an_end_is_not_read() -> None:
    transfer = ItemTransfer(0.0, AUTOPILOT, OWN, FENCE)
    count = dialect.MAVLink_mission_count_message(*OWN, MOST_ITEMS + 1, FENCE)
    assert answers(transfer, count) == []
    assert transfer.state is TransferState.FAILED


def test_what_is_meant_for_others_is_passed_over() -> None:
    transfer = ItemTransfer(0.0, AUTOPILOT, OWN, FENCE)
    for theirs in (
        dialect.MAVLink_mission_count_message(*OTHER, 3, FENCE),
        dialect.MAVLink_mission_count_message(*OWN, 3, dialect.MAV_MISSION_TYPE_RALLY),
        dialect.MAVLink_mission_ack_message(*OTHER, dialect.MAV_MISSION_DENIED, FENCE),
    ):
        assert answers(transfer, theirs) == []
    assert transfer.state is TransferState.ASKING


def test_an_upload_is_done_when_all_was_asked_for() -> None:
    """An acknowledgement of somebody's upload before ours says nothing of it."""
    transfer = ItemTransfer(0.0, AUTOPILOT, OWN, FENCE, ITEMS[:2])
    accepted = dialect.MAVLink_mission_ack_message(*OWN, dialect.MAV_MISSION_ACCEPTED, FENCE)
    ask = [dialect.MAVLink_mission_request_int_message(*OWN, seq, FENCE) for seq in range(2)]
    answers(transfer, accepted, ask[0], accepted)
    before = transfer.state
    answers(transfer, ask[1], accepted)
    assert (before, transfer.state) == (TransferState.WRITING, TransferState.DONE)


def test_one_that_is_busy_with_this_very_upload_goes_on_with_it() -> None:
    """As where MISSION_COUNT came twice."""
    transfer = ItemTransfer(0.0, AUTOPILOT, OWN, FENCE, ITEMS[:3])
    ask = [dialect.MAVLink_mission_request_int_message(*OWN, seq, FENCE) for seq in range(3)]
    busy = dialect.MAVLink_mission_ack_message(*OWN, dialect.MAV_MISSION_ERROR, FENCE)
    accepted = dialect.MAVLink_mission_ack_message(*OWN, dialect.MAV_MISSION_ACCEPTED, FENCE)
    answers(transfer, ask[0], ask[1], busy, ask[1], ask[2], accepted)
    assert transfer.state is TransferState.DONE


NAMES = sorted(TRANSFER_MESSAGES)
NUMBER = st.integers(0, 65535)
FLOAT = st.floats(width=32)
COORDINATE = st.integers(-(2**31), 2**31 - 1)


@given(
    is_writing=st.booleans(),
    said=st.lists(
        st.tuples(st.sampled_from(sorted(TRANSFER_MESSAGES)), NUMBER, FLOAT, COORDINATE),
        max_size=40,
    ),
)
def test_no_answer_raises_and_every_transfer_ends(
    is_writing: bool, said: list[tuple[str, int, float, int]]
) -> None:
    transfer = ItemTransfer(0.0, AUTOPILOT, OWN, FENCE, ITEMS if is_writing else None)
    now_s, sent = 0.0, 0
    for name, number, value, x in said:
        now_s += TICK_S
        sent += len(transfer.take(now_s, _message(name, number, value, x)))
        sent += len(transfer.due(now_s))
    assert sent <= 2 * len(said)
    while transfer.is_under_way:
        now_s += 1.0
        assert len(transfer.due(now_s)) <= 1
    assert now_s <= LONGEST_S + 2.0


def _message(name: str, number: int, value: float, x: int) -> Any:
    match name:
        case "MISSION_COUNT":
            return dialect.MAVLink_mission_count_message(*OWN, number, FENCE)
        case "MISSION_ACK":
            return dialect.MAVLink_mission_ack_message(*OWN, number % 256, FENCE)
        case "MISSION_ITEM_INT":
            head = (*OWN, number % 4, number % 256, number, 0, 1, value, value, value, value)
            return dialect.MAVLink_mission_item_int_message(*head, x, -x - 1, value, FENCE)
        case "MISSION_REQUEST":
            return dialect.MAVLink_mission_request_message(*OWN, number, FENCE)
    return dialect.MAVLink_mission_request_int_message(*OWN, number % 12, FENCE)
