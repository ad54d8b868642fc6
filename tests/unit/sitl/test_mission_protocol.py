"""The mission protocol: losses, duplicates, several clients, garbage; PX4's answers and times."""

import math
import struct
from typing import Any

import pytest
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st
from plans import (
    ACCEPTED,
    CANCELLED,
    ERROR,
    INVALID_SEQUENCE,
    MISSION,
    NO_SPACE,
    UNSUPPORTED,
    UNSUPPORTED_FRAME,
    WAYPOINT,
    action,
    download,
    numbered,
    place,
    upload,
)
from wire import NAN, Wire

from companion.mavlink.framing import MavlinkCodec, dialect
from sitl.link.mission_items import MissionType, WireItem, check_item, int_message, wire_item
from sitl.link.mission_service import MOST_ITEMS, MissionService
from sitl.link.routing import LinkName

LINK = LinkName.OFFBOARD
A, B = (1, 191), (255, 190)


def missions() -> MissionService:
    return MissionService(lambda kind, items, current: None, lambda: 0)


class Client:
    """One end of a link to the stores, by its address."""

    def __init__(self, stores: MissionService, address: tuple[int, int] = A) -> None:
        self._stores = stores
        self._codec = MavlinkCodec(*address)

    def send(self, message: Any, now_s: float = 0.0) -> list[Any]:
        """The answers, after all have been bytes."""
        (arrived,) = self._codec.parse(self._codec.pack(message))
        answers = self._stores.receive(LINK, arrived, now_s)
        return [heard for each in answers for heard in MavlinkCodec(1, 1).parse(_packed(each))]


def _packed(message: Any) -> bytes:
    return MavlinkCodec(1, 1).pack(message)


def count(number: int, kind: int = 0) -> Any:
    return dialect.MAVLink_mission_count_message(1, 1, number, kind)


def waypoints(number: int, up_m: float = 5.0) -> list[Any]:
    return numbered([place(WAYPOINT, (float(i), 0.0, up_m)) for i in range(number)])


def stored(stores: MissionService, kind: MissionType = MissionType.MISSION) -> tuple[WireItem, ...]:
    return stores.items(kind)


# Uploads.


@given(
    number=st.integers(1, 6),
    fates=st.lists(st.sampled_from(["arrives", "lost", "twice"]), max_size=60),
)
def test_an_upload_survives_losses_and_duplicates(number: int, fates: list[str]) -> None:
    """A client that only answers; whatever is lost is asked for again."""
    stores = missions()
    client, items = Client(stores), waypoints(number)
    luck = iter(fates)

    def exchanged(message: Any, now_s: float) -> list[Any]:
        times = {"lost": 0, "twice": 2}.get(next(luck, "arrives"), 1)
        answers = [answer for _ in range(times) for answer in client.send(message, now_s)]
        return [answer for answer in answers if next(luck, "arrives") != "lost"]

    waiting = exchanged(count(number), 0.0)
    for step in range(400):
        now_s = step * 0.05
        if step % 10 == 0 and not stores.is_busy and not stored(stores):
            waiting += exchanged(count(number), now_s)
        waiting += [message for _, message in stores.due(now_s)]
        requests = [m for m in waiting if m.get_type() == "MISSION_REQUEST_INT"]
        waiting = [answer for r in requests for answer in exchanged(items[r.seq], now_s)]
        if stored(stores):
            break
    assert stored(stores) == tuple(wire_item(item) for item in items)
    assert not stores.is_busy


def test_what_is_lost_is_asked_for_every_quarter_of_a_second_for_five_seconds() -> None:
    stores = missions()
    client = Client(stores)
    client.send(count(3))
    client.send(waypoints(3)[0])
    sent = [(round(i * 0.01, 2), m) for i in range(600) for _, m in stores.due(i * 0.01)]
    requests, (end_s, end) = sent[:-1], sent[-1]
    assert [s for s, _ in requests] == pytest.approx([0.25 * i for i in range(1, 21)], abs=0.011)
    assert {(m.get_type(), m.seq) for _, m in requests} == {("MISSION_REQUEST_INT", 1)}
    assert (end.get_type(), end.type) == ("MISSION_ACK", CANCELLED)
    assert end_s == pytest.approx(5.0, abs=0.02)
    assert stored(stores) == ()
    assert client.send(waypoints(3)[1])[0].type == ERROR


@st.composite
def conversations(draw: st.DrawFn) -> list[tuple[str, int, Any]]:
    """What two clients send, in any order, with time that passes; every item is unlike any other.

    Mostly the next item, so that uploads get to their end.
    """
    talk: list[tuple[str, int, Any]] = []
    following = [0, 0]
    for unique in range(draw(st.integers(1, 40))):
        who = draw(st.integers(0, 1))
        verb = draw(
            st.sampled_from("count item item item item again clear wait cancel list".split())
        )
        number = draw(st.integers(0, 3))
        if verb == "count":
            following[who] = 0
            talk.append((verb, who, count(number)))
        elif verb in ("item", "again"):
            message = place(WAYPOINT, (0.0, 0.0, float(unique)))
            message.seq = number if verb == "again" else following[who]
            following[who] += verb == "item"
            talk.append(("item", who, message))
        elif verb == "clear":
            talk.append((verb, who, dialect.MAVLink_mission_clear_all_message(1, 1, 0)))
        elif verb == "cancel":
            talk.append((verb, who, dialect.MAVLink_mission_ack_message(1, 1, CANCELLED, 0)))
        elif verb == "list":
            talk.append((verb, who, dialect.MAVLink_mission_request_list_message(1, 1, 0)))
        else:
            talk.append((verb, who, number))
    return talk


@drawn(300)
@given(talk=conversations())
def test_a_store_is_as_before_or_what_one_client_has_sent_as_a_whole(
    talk: list[tuple[str, int, Any]],
) -> None:
    stores = missions()
    clients = [Client(stores, A), Client(stores, B)]
    promised = [0, 0]
    sent: list[list[tuple[int, Any]]] = [[], []]
    now_s = 0.0
    for verb, who, message in talk:
        if verb == "wait":
            now_s += 2.0 * message
            stores.due(now_s)
            continue
        before = stored(stores)
        answers = clients[who].send(message, now_s)
        if verb == "count" and any(a.get_type() == "MISSION_REQUEST_INT" for a in answers):
            promised[who], sent[who] = message.count, []
        if verb == "item":
            sent[who].append((message.seq, wire_item(message)))
        after = stored(stores)
        if after == before:
            continue
        assert [a.type for a in answers] == [ACCEPTED]
        if after:
            assert verb == "item" and len(after) == promised[who]
            assert all(pair in sent[who] for pair in enumerate(after))
        else:
            assert verb == "clear" or (verb == "count" and message.count == 0)


def test_another_client_has_to_wait_and_disturbs_nothing() -> None:
    stores = missions()
    first, second = Client(stores, A), Client(stores, B)
    items = waypoints(2)
    first.send(count(2))
    first.send(items[0])
    for message in (count(1), waypoints(1)[0], dialect.MAVLink_mission_clear_all_message(1, 1, 0)):
        assert [answer.type for answer in second.send(message)] == [ERROR]
    (end,) = first.send(items[1])
    assert (end.type, end.target_system, end.target_component) == (ACCEPTED, *A)
    assert len(stored(stores)) == 2


def test_the_last_item_again_is_acknowledged_again() -> None:
    stores = missions()
    client, items = Client(stores), waypoints(2)
    client.send(count(2))
    for item in items:
        client.send(item)
    assert [answer.type for answer in client.send(items[1])] == [ACCEPTED]
    assert [answer.type for answer in client.send(items[0])] == [ERROR]


def test_too_many_and_too_far() -> None:
    client = Client(missions())
    assert client.send(count(MOST_ITEMS[MissionType.MISSION] + 1))[0].type == NO_SPACE
    client.send(count(1))
    beyond = waypoints(8)[7]
    assert client.send(beyond)[0].type == INVALID_SEQUENCE


def test_unknown_kinds_are_unsupported() -> None:
    client = Client(missions())
    for message in (
        count(1, 7),
        dialect.MAVLink_mission_request_list_message(1, 1, 7),
        dialect.MAVLink_mission_clear_all_message(1, 1, 7),
    ):
        assert [answer.type for answer in client.send(message)] == [UNSUPPORTED]


def test_the_older_item_is_understood() -> None:
    stores = missions()
    client = Client(stores)
    (request,) = client.send(count(1))
    assert request.get_type() == "MISSION_REQUEST_INT"
    item = dialect.MAVLink_mission_item_message(
        1, 1, 0, 3, WAYPOINT, 1, 1, 0, 0, 0, NAN, 47.5, 8.25, 5.0, 0
    )
    assert client.send(item)[0].type == ACCEPTED
    (got,) = stored(stores)
    assert (got.frame, got.x, got.y, got.z, got.parameters[3]) == (3, 47.5, 8.25, 5.0, None)


def in_frame(item: Any, frame: int, command: int | None = None) -> WireItem:
    item.frame, item.command = frame, item.command if command is None else command
    return wire_item(item)


MAVSDK_ITEMS = (1000, 1001, 2000, 2001, 2500, 2501, 205, 206, 530, 178, 93, 20)


@pytest.mark.parametrize(
    ("kind", "item", "answer"),
    [
        *((MissionType.MISSION, in_frame(action(c), MISSION), ACCEPTED) for c in MAVSDK_ITEMS),
        *(
            (MissionType.MISSION, wire_item(place(c, (1, 1, 1))), ACCEPTED)
            for c in (16, 17, 19, 21, 22)
        ),
        (MissionType.MISSION, wire_item(place(195, (1, 1, 1))), ACCEPTED),
        (MissionType.MISSION, in_frame(place(16, (1, 1, 1)), 0), ACCEPTED),
        (MissionType.MISSION, in_frame(place(16, (1, 1, 1)), 1), UNSUPPORTED_FRAME),
        (MissionType.MISSION, in_frame(place(16, (1, 1, 1)), 10), UNSUPPORTED_FRAME),
        (MissionType.MISSION, wire_item(place(82, (1, 1, 1))), UNSUPPORTED),
        (MissionType.MISSION, in_frame(action(16), MISSION), UNSUPPORTED),
        (MissionType.MISSION, wire_item(place(178, (1, 1, 1))), UNSUPPORTED),
        (MissionType.MISSION, wire_item(place(5001, (1, 1, 1), 3.0)), UNSUPPORTED),
        (MissionType.FENCE, wire_item(place(16, (1, 1, 1))), UNSUPPORTED),
        (MissionType.FENCE, wire_item(place(5001, (1, 1, 1), 2.0)), ERROR),
        (MissionType.FENCE, wire_item(place(5001, (1, 1, 1), 3.0)), ACCEPTED),
        (MissionType.FENCE, wire_item(place(5003, (1, 1, 1), NAN)), 6),
        (MissionType.FENCE, wire_item(place(5000, (1, 1, 1))), ACCEPTED),
        (MissionType.RALLY, wire_item(place(5100, (1, 1, 1))), ACCEPTED),
    ],
)
def test_which_items_are_taken(kind: MissionType, item: WireItem, answer: int) -> None:
    assert check_item(kind, item) == answer


def test_an_item_that_is_refused_ends_the_upload() -> None:
    stores = missions()
    client = Client(stores)
    client.send(count(2))
    assert client.send(numbered([place(82, (1, 1, 1))])[0])[0].type == UNSUPPORTED
    assert not stores.is_busy


# Downloads.

FLOAT32 = st.floats(width=32, allow_nan=True, allow_infinity=False)


@given(
    command=st.integers(0, 65535),
    frame=st.sampled_from([MISSION, 5, 6]),
    parameters=st.tuples(FLOAT32, FLOAT32, FLOAT32, FLOAT32),
    x=st.integers(-900_000_000, 900_000_000),
    y=st.integers(-1_800_000_000, 1_800_000_000),
    z=FLOAT32,
    autocontinue=st.integers(0, 1),
)
def test_an_item_comes_back_bit_by_bit(
    command: int,
    frame: int,
    parameters: tuple[float, ...],
    x: int,
    y: int,
    z: float,
    autocontinue: int,
) -> None:
    message = dialect.MAVLink_mission_item_int_message(
        *A, 3, frame, command, 1, autocontinue, *parameters, x, y, z, 0
    )
    back = int_message(wire_item(message), 3, A, MissionType.MISSION, True)
    for name in message.fieldnames:
        sent, got = getattr(message, name), getattr(back, name)
        assert got == sent or (math.isnan(got) and math.isnan(sent)), name


def test_a_download_is_one_picture_in_any_order_and_form() -> None:
    wire = Wire()
    old, new = waypoints(3), waypoints(2, up_m=9.0)
    assert upload(wire, old) == ACCEPTED
    wire.send(dialect.MAVLink_mission_request_list_message(1, 1, 0))
    reader, wire.codec = wire.codec, MavlinkCodec(*B)  # who downloads does not upload meanwhile
    wire.send(count(2))
    for item in new:
        wire.send(item)
    wire.codec = reader
    for seq in (2, 0, 2, 1):
        wire.send(dialect.MAVLink_mission_request_int_message(1, 1, seq, 0))
        got = wire.last("MISSION_ITEM_INT")
        assert (got.seq, got.z, got.x, got.frame) == (seq, 5.0, old[seq].x, 6)
    wire.send(dialect.MAVLink_mission_request_message(1, 1, 1, 0))
    older = wire.last("MISSION_ITEM")
    assert (older.frame, older.z) == (3, 5.0)
    assert older.x == struct.unpack("<f", struct.pack("<f", old[1].x / 1e7))[0]
    assert [item.z for item in download(wire)] == [9.0, 9.0]


def test_requests_without_a_list_or_after_the_end_are_passed_over() -> None:
    wire = Wire()
    upload(wire, waypoints(2))
    request = dialect.MAVLink_mission_request_int_message(1, 1, 1, 0)
    wire.send(request)
    assert wire.named("MISSION_ITEM_INT") == []
    download(wire)
    heard = len(wire.named("MISSION_ITEM_INT"))
    wire.send(request)
    wire.send(dialect.MAVLink_mission_request_list_message(1, 1, 0))
    wire.run(5.1)
    wire.send(request)
    assert len(wire.named("MISSION_ITEM_INT")) == heard
    wire.send(dialect.MAVLink_mission_request_list_message(1, 1, 0))
    wire.send(dialect.MAVLink_mission_request_int_message(1, 1, 2, 0))
    assert wire.last("MISSION_ACK").type == INVALID_SEQUENCE


# On the wire.


def test_three_stores_and_one_message_that_clears_them_all() -> None:
    wire = Wire()
    plans = {
        0: [place(WAYPOINT, (1, 2, 3))],
        1: [place(5003, (0, 0, 0), 50.0, kind=1)],
        2: [place(5100, (9, 9, 9), kind=2)],
    }
    for kind, items in plans.items():
        assert upload(wire, items, kind) == ACCEPTED
    assert {kind: [i.command for i in download(wire, kind)] for kind in plans} == {
        0: [WAYPOINT],
        1: [5003],
        2: [5100],
    }
    wire.send(dialect.MAVLink_mission_clear_all_message(1, 1, 1))
    assert [len(download(wire, kind)) for kind in plans] == [1, 0, 1]
    wire.send(dialect.MAVLink_mission_clear_all_message(1, 1, 255))
    assert (wire.last("MISSION_ACK").type, wire.last("MISSION_ACK").mission_type) == (ACCEPTED, 255)
    assert [len(download(wire, kind)) for kind in plans] == [0, 0, 0]


def test_requests_go_again_to_the_link_they_came_from() -> None:
    wire = Wire(link=LinkName.GCS, address=B)
    wire.send(count(2))
    wire.run(1.1)
    assert len(wire.named("MISSION_REQUEST_INT")) == 5
    assert wire.named("MISSION_REQUEST_INT", LinkName.OFFBOARD) == []


def test_set_current_is_answered_at_once_with_px4s_values() -> None:
    wire = Wire()
    upload(wire, waypoints(4))
    wire.run(0.2)
    wire.send(dialect.MAVLink_mission_set_current_message(1, 1, 1))
    told = wire.last("MISSION_CURRENT")
    assert (told.seq, told.total, told.mission_state, told.mission_mode) == (1, 4, 2, 2)
    heard = len(wire.named("MISSION_CURRENT"))
    wire.send(dialect.MAVLink_mission_set_current_message(1, 1, 4))
    assert len(wire.named("MISSION_CURRENT")) == heard
    assert [item.current for item in download(wire)] == [0, 1, 0, 0]


# Garbage.

NAMES = sorted(MissionService.HANDLERS)
FORMATS = {
    "float": st.floats(width=32),
    "uint8_t": st.integers(0, 2**8 - 1) | st.integers(0, 6),
    "uint16_t": st.integers(0, 2**16 - 1) | st.integers(0, 3) | st.sampled_from([16, 5001, 177]),
    "int32_t": st.integers(-(2**31), 2**31 - 1),
}


@st.composite
def garbage(draw: st.DrawFn) -> Any:
    name = draw(st.sampled_from(NAMES))
    kind = getattr(dialect, f"MAVLink_{name.lower()}_message")
    values = {
        field: draw(FORMATS[form])
        for field, form in zip(kind.fieldnames, kind.fieldtypes, strict=True)
    }
    return kind(**values | {"target_system": 1, "target_component": 1})


@pytest.mark.long
@drawn(100)
@given(messages=st.lists(garbage(), max_size=20))
def test_nothing_that_can_be_sent_raises(messages: list[Any]) -> None:
    wire = Wire()
    for message in messages:
        wire.send(message)
    wire.send(count(2, 0))
    wire.run(0.4)
    for kind in range(3):
        download(wire, kind)
