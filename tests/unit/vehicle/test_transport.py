"""Streams: a serial port is one end of a pseudo-terminal here, a TCP server one on the loopback."""

from __future__ import annotations

import asyncio
import os
import pty
import socket
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import TypeVar

import pytest

from companion.cli.signing_relay import PAUSE_S, relayed
from companion.flight_events.hosting import PortLost, PortRestored
from companion.mavlink.framing import MavlinkCodec, dialect
from companion.mavlink.signing import Signing, SigningKey
from companion.vehicle import link as link_module
from companion.vehicle.endpoints import SerialPort, TcpServer, UdpPeer, parse_url
from companion.vehicle.link import Link
from companion.vehicle.transport import TRY_AGAIN_S

PATIENCE_S = 60.0

T = TypeVar("T")


def heartbeat(component: int = 1) -> bytes:
    return MavlinkCodec(1, component).pack(dialect.MAVLink_heartbeat_message(2, 12, 0, 0, 3, 3))


def until(look: Callable[[], T]) -> T:
    """What a look finds, as soon as it finds something."""
    end_s = time.monotonic() + PATIENCE_S
    while not (found := look()):
        assert time.monotonic() < end_s, "in vain"
        time.sleep(0.01)
    return found


class Board:
    """An autopilot's serial port, under a name that stays when it is plugged in again."""

    def __init__(self, name: Path) -> None:
        self.name = name
        self.plug_in()

    def plug_in(self) -> None:
        self.ours, self._theirs = pty.openpty()
        tty.setraw(self._theirs)
        os.set_blocking(self.ours, False)
        self.name.unlink(missing_ok=True)
        self.name.symlink_to(os.ttyname(self._theirs))

    def unplug(self) -> None:
        self.name.unlink()
        os.close(self.ours)
        os.close(self._theirs)

    def read(self) -> bytes:
        try:
            return os.read(self.ours, 4096)
        except BlockingIOError:
            return b""


@pytest.fixture
def board(tmp_path: Path) -> Iterator[Board]:
    made = Board(tmp_path / "ttyTHS1")
    yield made
    made.unplug()


@pytest.fixture
def serial_link(board: Board) -> Iterator[Link]:
    with closing(Link(SerialPort(str(board.name), 921600))) as link:
        yield link


def test_frames_pass_a_serial_port_in_both_directions(board: Board, serial_link: Link) -> None:
    serial_link.receive()
    serial_link.send([])
    assert until(board.read)[5:6] == b"\x01", "we call as the companion of system 1"
    os.write(board.ours, b"boot" + heartbeat()[:7])
    assert serial_link.wait(PATIENCE_S) and serial_link.receive() == []
    os.write(board.ours, heartbeat()[7:] + heartbeat(42))
    heard: list[bytes] = []

    def has_both() -> bool:
        heard.extend(serial_link.receive())
        return len(heard) == 2

    until(has_both)
    assert heard == [heartbeat(), heartbeat(42)]
    serial_link.send([heartbeat(191)])
    assert until(board.read) == heartbeat(191), "and call no longer"
    assert "the autopilot of 1 was heard" in serial_link.account()


def test_a_serial_port_that_comes_back_is_opened_again(board: Board, serial_link: Link) -> None:
    assert serial_link.receive() == []
    os.write(board.ours, heartbeat())
    assert until(serial_link.receive) == [heartbeat()]
    board.unplug()
    (lost,) = until(lambda: serial_link.receive() or serial_link.news())
    assert isinstance(lost, PortLost) and lost.port == f"serial://{board.name}:921600"
    serial_link.send([heartbeat(191)])
    board.plug_in()
    until(lambda: serial_link.receive() or os.write(board.ours, heartbeat()) < 0)
    assert serial_link.news() == [PortRestored(lost.port)]


def test_a_port_that_is_not_there_is_told_once_and_tried_again(tmp_path: Path) -> None:
    name = tmp_path / "ttyUSB0"
    with closing(Link(SerialPort(str(name), 57600))) as link:
        assert link.receive() == []
        (lost,) = link.news()
        assert isinstance(lost, PortLost) and "No such file" in lost.reason
        assert not link.wait(TRY_AGAIN_S) and link.receive() == [] and link.news() == []


def test_a_full_line_loses_whole_frames_and_never_waits(board: Board, serial_link: Link) -> None:
    serial_link.receive()
    os.write(board.ours, heartbeat())
    until(serial_link.receive)
    board.read()
    begun_s = time.monotonic()
    serial_link.send([heartbeat(191)] * 20_000)
    assert time.monotonic() - begun_s < PATIENCE_S / 10
    heard = b"".join(iter(board.read, b""))
    serial_link.send([heartbeat(190)])
    heard += b"".join(iter(board.read, b""))
    assert 0 < len(heard) < 20_000 * len(heartbeat())
    assert heard.removesuffix(heartbeat(190)) == heartbeat(191) * (
        len(heard) // len(heartbeat()) - 1
    )


def test_a_server_is_connected_to_until_it_is_there_and_again() -> None:
    with socket.create_server(("127.0.0.1", 0)) as reserved:
        port = reserved.getsockname()[1]
    with closing(Link(TcpServer("127.0.0.1", port))) as link:
        (lost,) = until(lambda: link.receive() or link.news())
        assert isinstance(lost, PortLost) and "refused" in lost.reason
        for _ in range(2):
            with socket.create_server(("127.0.0.1", port)) as server:
                server.setblocking(False)
                peer = until(lambda: link.receive() or accepted(server))
            assert isinstance(peer, socket.socket)
            with peer:
                peer.sendall(heartbeat())
                assert until(link.receive) == [heartbeat()]
                assert link.news() == [PortRestored(f"tcpout://127.0.0.1:{port}")]
                link.send([heartbeat(191)])
                assert peer.recv(1000).endswith(heartbeat(191))
            (gone,) = until(lambda: link.receive() or link.news())
            assert isinstance(gone, PortLost)


def accepted(server: socket.socket) -> socket.socket | None:
    try:
        connection, _ = server.accept()
    except BlockingIOError:
        return None
    connection.settimeout(PATIENCE_S)
    return connection


def test_a_caller_calls_until_somebody_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    """As PX4 waits on its port for the first datagram."""
    monkeypatch.setattr(link_module, "CALL_S", 2 * PATIENCE_S)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:
        peer.bind(("127.0.0.1", 0))
        peer.settimeout(PATIENCE_S)
        with closing(Link(parse_url(f"udpout://127.0.0.1:{peer.getsockname()[1]}"))) as link:
            link.send([])
            (call,) = MavlinkCodec(0, 0).parse(peer.recv(100))
            assert (call.get_srcSystem(), call.get_srcComponent()) == (1, 191)
            assert (
                call.get_type() == "HEARTBEAT" and call.autopilot == dialect.MAV_AUTOPILOT_INVALID
            )
            link.send([])
            peer.setblocking(False)
            with pytest.raises(BlockingIOError):
                peer.recv(100)


def test_a_relay_calls_nobody() -> None:
    """On the ground a heartbeat of component 191 would pass for the companion's."""

    async def wait_with_a_relay(endpoint: UdpPeer) -> None:
        with relayed(endpoint, Signing(SigningKey(bytes(32)), time.time())):
            await asyncio.sleep(4 * PAUSE_S)

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:
        peer.bind(("127.0.0.1", 0))
        asyncio.run(wait_with_a_relay(UdpPeer("127.0.0.1", peer.getsockname()[1])))
        peer.setblocking(False)
        with pytest.raises(BlockingIOError):
            peer.recv(100)
