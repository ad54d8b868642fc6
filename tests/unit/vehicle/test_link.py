"""The doors: URLs, a socket on the loopback, and a clock."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator
from contextlib import closing
from typing import Any

import pytest
from autopilot import Autopilot

from companion.errors import LinkError
from companion.flight_events.hosting import DatagramsDropped, FramesRefused
from companion.mavlink.framing import MavlinkCodec as Speaker
from companion.mavlink.framing import dialect
from companion.mavlink.intake import LONGEST, SENDER_FRAMES
from companion.mavlink.signing import Signing, SigningKey, of_signed_vehicle
from companion.vehicle.endpoints import Endpoint, SerialPort, TcpServer, UdpPeer, UdpPort, parse_url
from companion.vehicle.link import HOSTS_NAMED, Link

PATIENCE_S = 60.0  # for datagrams on the loopback; they take microseconds


def heartbeat(component: int = 1) -> bytes:
    return Speaker(1, component).pack(dialect.MAVLink_heartbeat_message(2, 12, 0, 0, 3, 3))


# -- URLs ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("url", "expected"),
    [
        ("udpin://0.0.0.0:14540", UdpPort("0.0.0.0", 14540)),
        ("udpin:0.0.0.0:14540", UdpPort("0.0.0.0", 14540)),
        ("udpin://:14540", UdpPort("0.0.0.0", 14540)),
        ("udpin://127.0.0.1:14540/", UdpPort("127.0.0.1", 14540)),
        ("udpout:192.168.1.10:14580", UdpPeer("192.168.1.10", 14580)),
        ("udpout://drone.local:65535", UdpPeer("drone.local", 65535)),
        ("tcpout://10.0.0.1:5760", TcpServer("10.0.0.1", 5760)),
        ("tcp:10.0.0.1:5760", TcpServer("10.0.0.1", 5760)),
        ("serial:///dev/ttyTHS1:921600", SerialPort("/dev/ttyTHS1", 921600)),
        ("serial:/dev/ttyACM0:57600", SerialPort("/dev/ttyACM0", 57600)),
        ("serial://COM3:57600", SerialPort("COM3", 57600)),
    ],
)
def test_the_spellings_of_a_url(url: str, expected: Endpoint) -> None:
    assert parse_url(url) == expected
    assert parse_url(str(expected)) == expected


@pytest.mark.parametrize(
    "url",
    [
        "",
        "14540",
        "udpin",
        "udpin://",
        "udpin://host",
        "udpin://host:port",
        "udpin://host:65536",
        "udpin://host:-1",
        "tcpin://host:5760",
        "UDPIN://host:14540",
        "udpin://host:14540/path",
        "udpin://host:14540\nudpin://host:14541",
    ],
)
def test_what_is_no_url_is_refused_with_what_to_write(url: str) -> None:
    with pytest.raises(LinkError) as error:
        parse_url(url)
    assert str(error.value).startswith(f"cannot connect to {url}\n")
    assert "udpin://0.0.0.0:14540" in str(error.value)


def test_an_address_of_another_machine_is_not_listened_on() -> None:
    with pytest.raises(LinkError, match="this machine has no such address"):
        Link(UdpPort("192.0.2.1", 14540))


@pytest.mark.parametrize("url", ["serial:///dev/ttyACM0", "serial:/dev/ttyACM0:0"])
def test_a_serial_port_has_a_speed(url: str) -> None:
    with pytest.raises(LinkError, match="write serial:///dev/ttyACM0:921600, with the speed"):
        parse_url(url)


@pytest.mark.parametrize("url", ["udp://:14540", "udp:14540"])
def test_a_bare_udp_means_two_things(url: str) -> None:
    with pytest.raises(LinkError) as error:
        parse_url(url)
    assert "ambiguous" in str(error.value)
    assert "udpin://0.0.0.0:14540" in str(error.value)
    assert "udpout://127.0.0.1:14540" in str(error.value)


# -- sockets ---------------------------------------------------------------------------------------


class Peer:
    """The other end, with a port of its own."""

    def __init__(self, host: str = "127.0.0.1") -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((host, 0))
        self.socket.settimeout(PATIENCE_S)

    @property
    def address(self) -> tuple[str, int]:
        host, port = self.socket.getsockname()
        return host, port

    def hears_nothing(self) -> bool:
        self.socket.setblocking(False)
        try:
            self.socket.recv(1000)
        except BlockingIOError:
            return True
        return False


@pytest.fixture
def peer() -> Iterator[Peer]:
    found = Peer()
    with closing(found.socket):
        yield found


@pytest.fixture
def listener() -> Iterator[Link]:
    made = Link(UdpPort("127.0.0.1", 0))
    with closing(made):
        yield made


def address_of(made: Link) -> tuple[str, int]:
    transport: Any = made.transport
    host, port = transport.address
    return host, port


def deliver(peer: Peer, made: Link, *datagrams: bytes) -> list[bytes]:
    """Sends datagrams to a link and returns what it received."""
    received: list[bytes] = []
    for datagram in datagrams:
        peer.socket.sendto(datagram, address_of(made))
        made.wait(PATIENCE_S)
        received += made.receive()
    return received


def test_a_listener_answers_the_autopilot_that_sends_heartbeats(peer: Peer, listener: Link) -> None:
    assert deliver(peer, listener, heartbeat()) == [heartbeat()]
    listener.send([b"one", b"two"])
    assert [peer.socket.recv(100) for _ in range(2)] == [b"one", b"two"]


@pytest.mark.parametrize("datagram", [b"junk", heartbeat(component=191), b"\xfe" + bytes(20)])
def test_a_listener_does_not_answer_anybody_else(
    peer: Peer, listener: Link, datagram: bytes
) -> None:
    assert deliver(peer, listener, datagram) == [datagram]
    listener.send([b"hello"])
    assert peer.hears_nothing()


def test_a_ground_station_on_the_port_does_not_divert_the_answers(
    peer: Peer, listener: Link
) -> None:
    deliver(peer, listener, heartbeat())
    other = Peer()
    with closing(other.socket):
        deliver(other, listener, heartbeat(component=190))
    listener.send([b"hello"])
    assert peer.socket.recv(100) == b"hello"


def test_a_caller_sends_first_and_hears_the_answer(peer: Peer) -> None:
    with closing(Link(UdpPeer(*peer.address))) as caller:
        caller.send([b"hello"])
        call, datagram = (peer.socket.recvfrom(100) for _ in range(2))
        sender = call[1]
        assert datagram == (b"hello", sender)
        peer.socket.sendto(heartbeat(), sender)
        caller.wait(PATIENCE_S)
        assert caller.receive() == [heartbeat()]


def test_receive_takes_all_that_has_arrived_and_does_not_wait(peer: Peer, listener: Link) -> None:
    assert listener.receive() == []
    for _ in range(50):
        peer.socket.sendto(heartbeat(), address_of(listener))
    received: list[bytes] = []
    while len(received) < 50:
        listener.wait(PATIENCE_S)
        received += listener.receive()
    assert received == [heartbeat()] * 50


def test_what_has_arrived_may_be_discarded(peer: Peer) -> None:
    """All of it, also more than a step takes in; what comes later is received."""
    with closing(Link(parse_url("udpin://127.0.0.1:0"))) as link:
        to = address_of(link)
        for i in range(2000):
            peer.socket.sendto(b"old %d" % i, to)
        link.discard()
        assert link.receive() == []
        peer.socket.sendto(b"", to)
        peer.socket.sendto(b"new", to)
        assert link.wait(PATIENCE_S)
        link.discard()
        assert not link.wait(0.0)


def test_a_datagram_that_is_too_long_is_refused_and_told(peer: Peer, listener: Link) -> None:
    assert listener.news() == []
    empty = b"\xfe\x00\x00\x01\x01\x00\x00\x00"
    sent = [heartbeat(), empty * (65_507 // 8), bytes(LONGEST + 1), bytes(LONGEST)]
    assert deliver(peer, listener, *sent) == [heartbeat(), bytes(LONGEST)]
    assert listener.news() == [DatagramsDropped(2)]


@pytest.mark.parametrize("is_listening", [True, False], ids=["udpin", "udpout"])
def test_a_flood_does_not_displace_the_autopilot(peer: Peer, is_listening: bool) -> None:
    flooder, host = Peer(), UdpPort("127.0.0.1", 0)
    link = Link(host if is_listening else UdpPeer(*peer.address))
    with closing(link), closing(flooder.socket):
        link.send([b"hello"])
        deliver(peer, link, *[heartbeat()] * is_listening)
        for step in range(3):
            alien = [b for _ in range(200) for b in deliver(flooder, link, heartbeat(191))]
            assert len(alien) == SENDER_FRAMES
            assert deliver(peer, link, *[heartbeat()] * 30) == [heartbeat()] * 30
            dropped = [[DatagramsDropped(72)], [DatagramsDropped(144)], []]
            assert link.news() == dropped[step]
            link.send([])


def test_on_a_signed_link_only_a_signed_autopilot_is_answered(peer: Peer) -> None:
    """What is refused is not learned from, and named where no vehicle was heard."""
    key, other = SigningKey(bytes(32)), SigningKey(bytes(range(32)))
    vehicle, forger = Signing(key, time.time()), Signing(other, time.time())
    attacker = Peer()
    made = Signing(key, time.time(), of_signed_vehicle)
    with (
        closing(Link(UdpPort("127.0.0.1", 0), made)) as link,
        closing(attacker.socket),
    ):
        forged = [heartbeat(), *forger.send(0.0, [heartbeat()])]
        assert deliver(attacker, link, *forged) == []
        assert "no autopilot was heard; refused: 1 unsigned, 1 with another key" in link.account()
        assert link.news() == [FramesRefused(1, 1, 0)] and link.news() == []
        signed = vehicle.send(0.0, [heartbeat()])
        assert deliver(peer, link, *signed) == signed
        assert deliver(attacker, link, *signed) == []
        link.send([heartbeat(191)])
        assert vehicle.receive(0.0, [peer.socket.recv(100)])
        assert attacker.hears_nothing()


def test_hosts_without_number_are_not_all_kept(listener: Link) -> None:
    for number in range(20):
        sender = Peer(f"127.0.0.{2 + number}")
        with closing(sender.socket):
            deliver(sender, listener, b"junk")
    account = listener.account()
    assert account.startswith("20 packets") and account.count("127.0.0.") == HOSTS_NAMED


def test_what_the_network_does_not_take_is_lost() -> None:
    with closing(Link(UdpPeer("127.0.0.1", 9))) as caller:
        caller.send([bytes(70_000), b"hello"])  # larger than any datagram


def test_a_port_that_is_taken_says_by_whom_it_may_be(listener: Link) -> None:
    taken = UdpPort(*address_of(listener))
    with pytest.raises(LinkError, match=rf"cannot listen on {taken}: .*\n.*another program"):
        Link(taken)


def test_the_account_of_what_was_heard(peer: Peer, listener: Link) -> None:
    assert listener.account() == "nothing arrived"
    deliver(peer, listener, b"junk")
    assert listener.account().startswith("1 packets came from 127.0.0.1, none of them MAVLink 2")
    deliver(peer, listener, heartbeat(191), heartbeat(191))
    assert listener.account() == (
        "3 packets came from 127.0.0.1, 2 of them MAVLink 2; no autopilot was heard"
    )


def test_a_second_vehicle_does_not_divert_the_answers(listener: Link) -> None:
    first, second = Peer(), Peer()
    with closing(first.socket), closing(second.socket):
        for peer, system in ((first, 1), (second, 2)):
            deliver(peer, listener, Autopilot(system).telemetry()[0])
        listener.send([b"x"])
        assert first.socket.recv(100) == b"x"


def test_the_account_knows_an_autopilot(peer: Peer, listener: Link) -> None:
    deliver(peer, listener, heartbeat())
    assert "the autopilot of 1 was heard" in listener.account()


def test_a_host_that_nobody_knows_is_refused_at_once() -> None:
    with pytest.raises(LinkError, match=r"cannot find no\.such\.host\.invalid"):
        Link(parse_url("udpout://no.such.host.invalid:14540"))
