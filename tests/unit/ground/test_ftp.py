"""The server against the protocol: replies, sessions, repeats, bursts, and what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest
from ftp_client import ACK, Client, pack
from pymavlink.dialects.v20 import common
from pymavlink.mavftp import FTP_OP

from companion.ground.ftp import FtpServer
from companion.ground.ftp_services import BURST
from companion.ground.mission_store import MissionStore
from companion.mavlink.ftp_frames import Nak, Opcode, crc32

CONTENT = bytes(range(256)) * 40


@pytest.fixture
def root(tmp_path: Path) -> Path:
    return tmp_path / "incoming"


@pytest.fixture
def client(root: Path) -> Client:
    return Client(FtpServer(MissionStore(root)))


def test_what_is_put_can_be_got_and_is_named_once_as_stored(client: Client, root: Path) -> None:
    client.put("/a.yaml", CONTENT)
    assert (root / "a.yaml").read_bytes() == CONTENT
    assert client.get("a.yaml") == CONTENT
    assert client.server.take_stored() == ["/a.yaml"]


def test_numbers_are_those_of_the_dialect_and_headers_those_of_pymavlink() -> None:
    shortened = {"RESETSESSIONS": "RESETSESSION", "CALCFILECRC32": "CALCFILECRC"}
    for kind, enum in (Opcode, "MAV_FTP_OPCODE"), (Nak, "MAV_FTP_ERR"):
        for ours in kind:
            name = ours.name.replace("_", "")
            assert common.enums[enum][ours].name == f"{enum}_{shortened.get(name, name)}"
    op = FTP_OP(7, 3, Opcode.READ_FILE, 239, 0, 0, 4096, None)
    assert bytes(op.pack()) == pack(7, Opcode.READ_FILE, session=3, size=239, offset=4096)[:12]


def test_a_folder_is_listed_in_parts_until_its_end(client: Client) -> None:
    client.ask(Opcode.CREATE_DIRECTORY, "/maps")
    names = [f"mission-{i:02d}.yaml" for i in range(30)]
    for name in names:
        client.put(name, b"x" * 7)
    listed: list[bytes] = []
    while (part := client.ask(Opcode.LIST_DIRECTORY, "/", offset=len(listed))).nak is None:
        listed += part.data.removesuffix(b"\0").split(b"\0")
    assert part.nak is Nak.EOF
    assert listed == [b"Dmaps", *(f"F{name}\t7".encode() for name in names)]
    assert client.ask(Opcode.LIST_DIRECTORY, "/maps").nak is Nak.EOF


def test_a_file_keeps_its_old_content_until_the_upload_has_ended(client: Client) -> None:
    client.put("a.yaml", b"old")
    opened = client.ask(Opcode.CREATE_FILE, "a.yaml")
    client.ask(Opcode.WRITE_FILE, b"new one", session=opened.session)
    assert client.get("a.yaml") == b"old"
    client.ask(Opcode.TERMINATE_SESSION, session=opened.session)
    assert client.get("a.yaml") == b"new one"


def test_parts_may_come_in_any_order_but_none_may_be_missing(client: Client) -> None:
    for order, is_whole in ((2, 0, 1), True), ((2, 0), False):
        opened = client.ask(Opcode.CREATE_FILE, "a.yaml")
        for i in order:
            data = CONTENT[i * 200 : (i + 1) * 200]
            assert not client.ask(
                Opcode.WRITE_FILE, data, session=opened.session, offset=i * 200
            ).nak
        ended = client.ask(Opcode.TERMINATE_SESSION, session=opened.session)
        assert ended.nak is (None if is_whole else Nak.FAIL)
        assert client.get("a.yaml") == CONTENT[:600]


def test_an_upload_that_stops_leaves_nothing_after_30_s(client: Client) -> None:
    client.put("a.yaml", b"old")
    opened = client.ask(Opcode.CREATE_FILE, "a.yaml")
    client.ask(Opcode.WRITE_FILE, b"half", session=opened.session)
    client.now_s = 31.0
    assert client.ask(Opcode.TERMINATE_SESSION, session=opened.session).nak is Nak.INVALID_SESSION
    assert client.get("a.yaml") == b"old"


def test_a_repeated_request_gets_the_reply_that_was_lost(client: Client) -> None:
    client.put("a.yaml", b"x")
    for opcode, data in (
        (Opcode.CREATE_FILE, b"b.yaml"),
        (Opcode.RENAME, b"a.yaml\0c.yaml"),
        (Opcode.REMOVE_FILE, b"c.yaml"),
        (Opcode.CREATE_DIRECTORY, b"maps"),
        (Opcode.REMOVE_DIRECTORY, b"maps"),
    ):
        request = pack(500, opcode, data)
        first = client.send(request)
        assert first[0].nak is None
        assert client.send(request) == first
        client.ask(Opcode.NONE)
    ended = pack(900, Opcode.TERMINATE_SESSION)
    assert client.send(ended) == client.send(ended)
    assert client.get("b.yaml") == b""


def test_a_session_s_lost_reply_is_kept_while_others_go_on(client: Client) -> None:
    request = pack(0, Opcode.CREATE_FILE, b"a.yaml", session=175)
    first = client.send(request)
    assert client.ask(Opcode.CREATE_FILE, "b.yaml", session=176).session == 176
    assert client.send(request) == first
    assert client.ask(Opcode.WRITE_FILE, b"x", session=175).nak is None
    assert client.ask(Opcode.TERMINATE_SESSION, session=175).nak is None
    assert client.get("a.yaml") == b"x"


def test_a_client_that_starts_anew_uploads_anew(client: Client) -> None:
    for content in (b"long", b"new"):
        client.sequence = 0
        client.put("a.yaml", content)
        assert client.get("a.yaml") == content


def test_a_client_that_starts_anew_is_not_answered_from_memory(client: Client) -> None:
    listing, other = pack(1, Opcode.LIST_DIRECTORY, b"/"), Client(client.server, (254, 190))
    assert client.send(listing)[0].nak is Nak.EOF
    other.put("a.yaml", b"x")
    assert client.send(listing)[0].data == b"Fa.yaml\t1\0"


def test_the_number_that_a_client_has_chosen_is_its_sessions(client: Client) -> None:
    client.put("a.yaml", CONTENT)
    assert client.ask(Opcode.OPEN_FILE_RO, "a.yaml", session=175).session == 175
    second = client.ask(Opcode.OPEN_FILE_RO, "a.yaml", session=175)
    assert second.session != 175
    stranger = Client(client.server, (254, 190))
    assert stranger.ask(Opcode.READ_FILE, session=175, size=9).nak is Nak.INVALID_SESSION
    stranger.ask(Opcode.RESET_SESSIONS)
    assert client.ask(Opcode.READ_FILE, session=175, size=9).data == CONTENT[:9]


def test_there_are_eight_sessions_four_for_a_client(client: Client) -> None:
    client.put("a.yaml", b"x")
    clients = [client, Client(client.server, (254, 190)), Client(client.server, (253, 190))]
    for one in clients[:2]:
        for _ in range(4):
            assert one.ask(Opcode.OPEN_FILE_RO, "a.yaml").nak is None
    for one in clients:
        assert one.ask(Opcode.OPEN_FILE_RO, "a.yaml").nak is Nak.NO_SESSIONS_AVAILABLE
    clients[2].now_s = 31.0
    assert clients[2].ask(Opcode.OPEN_FILE_RO, "a.yaml").nak is None


@pytest.mark.parametrize("step", [239, 80])
def test_bursts_follow_each_other_to_the_end(client: Client, step: int) -> None:
    client.put("a.yaml", CONTENT)
    session = client.ask(Opcode.OPEN_FILE_RO, "a.yaml").session
    content, fields = b"", {"session": session, "size": step}
    while (replies := client.burst(Opcode.BURST_READ_FILE, b"", offset=len(content), **fields))[
        0
    ].nak is None:
        assert len(replies) <= BURST
        assert [r.ends_burst for r in replies] == [0] * (len(replies) - 1) + [1]
        for nth, reply in enumerate(replies):
            assert reply.sequence == client.sequence + 1 + nth
            assert reply.offset == len(content)
            content += reply.data
    assert content == CONTENT
    assert replies[0].nak is Nak.EOF


def test_opening_to_write_keeps_and_truncating_cuts(client: Client) -> None:
    client.put("a.yaml", b"0123456789")
    session = client.ask(Opcode.OPEN_FILE_WO, "a.yaml").session
    client.ask(Opcode.WRITE_FILE, b"x", session=session, offset=4)
    client.ask(Opcode.TERMINATE_SESSION, session=session)
    assert client.get("a.yaml") == b"0123x56789"
    assert client.ask(Opcode.TRUNCATE_FILE, "a.yaml", offset=5).nak is None
    assert client.get("a.yaml") == b"0123x"
    assert client.ask(Opcode.TRUNCATE_FILE, "a.yaml", offset=6).nak is Nak.INVALID_DATA_SIZE


def test_the_checksum_is_the_spec_s(client: Client) -> None:
    register = 0
    for byte in CONTENT:
        register ^= byte
        for _ in range(8):
            register = register >> 1 ^ (0xEDB88320 if register & 1 else 0)
    assert crc32(CONTENT) == register
    client.put("a.yaml", CONTENT)
    reply = client.ask(Opcode.CALC_FILE_CRC32, "a.yaml")
    assert int.from_bytes(reply.data, "little") == register


def test_what_cannot_be_done_is_refused_with_the_reason(client: Client) -> None:
    client.put("a.yaml", b"x")
    client.ask(Opcode.CREATE_DIRECTORY, "maps")
    reading = client.ask(Opcode.OPEN_FILE_RO, "a.yaml").session
    for opcode, data, reason in (
        (Opcode.OPEN_FILE_RO, "none.yaml", Nak.FILE_NOT_FOUND),
        (Opcode.OPEN_FILE_RO, "@PARAM/param.pck", Nak.FILE_NOT_FOUND),
        (Opcode.LIST_DIRECTORY, "a.yaml", Nak.FILE_NOT_FOUND),
        (Opcode.LIST_DIRECTORY, "/none", Nak.FILE_NOT_FOUND),
        (Opcode.CREATE_FILE, "none/a.yaml", Nak.FILE_NOT_FOUND),
        (Opcode.CREATE_FILE, "a.py", Nak.FILE_PROTECTED),
        (Opcode.CREATE_FILE, "verdict.json", Nak.FILE_PROTECTED),
        (Opcode.CREATE_DIRECTORY, "maps", Nak.FILE_EXISTS),
        (Opcode.CREATE_FILE, b"\xff", Nak.FAIL),
        (Opcode.CREATE_FILE, "", Nak.FILE_PROTECTED),
        (Opcode.RENAME, "a.yaml", Nak.FAIL),
        (Opcode.RENAME, "\0", Nak.FAIL),
        (Opcode.RENAME, "a.yaml\0maps", Nak.FILE_PROTECTED),
        (Opcode.REMOVE_FILE, "maps", Nak.FAIL),
    ):
        assert client.ask(opcode, data).nak is reason, (opcode, data)
    assert client.send(pack(9, 16, b"/"))[0].nak is Nak.UNKNOWN_COMMAND
    assert client.send(pack(9, Opcode.READ_FILE, size=240))[0].nak is Nak.INVALID_DATA_SIZE
    write = client.ask(Opcode.WRITE_FILE, b"y", session=reading)
    assert write.nak is Nak.FILE_PROTECTED
    assert client.send(pack(9, ACK)) == []  # a reply, which is never answered
    assert client.server.receive(0.0, (255, 190), b"short") == []


def test_a_file_that_is_too_large_ends_its_upload(client: Client, root: Path) -> None:
    session = client.ask(Opcode.CREATE_FILE, "a.yaml").session
    refused = client.ask(Opcode.WRITE_FILE, b"x", session=session, offset=256 * 1024)
    assert refused.nak is Nak.FAIL_ERRNO
    assert client.ask(Opcode.TERMINATE_SESSION, session=session).nak is Nak.INVALID_SESSION
    assert list(root.iterdir()) == []


def test_a_file_in_ten_thousand_pieces_is_refused_before_it_costs_time(client: Client) -> None:
    session = client.ask(Opcode.CREATE_FILE, "a.yaml").session
    replies = [
        client.ask(Opcode.WRITE_FILE, b"x", session=session, offset=2 * i) for i in range(100)
    ]
    assert replies[20].nak is None
    assert replies[-1].nak is Nak.INVALID_SESSION
