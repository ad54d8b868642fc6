"""The door of the flight side: a UDP socket. Everything else is a pure step.

A URL says who speaks first. `udpin` binds a port and answers the autopilot that sends heartbeats
to it (`autopilot_address.py`; PX4 sends to 14540 by itself); `udpout` sends to an address. A bare
`udp` means one thing to MAVSDK and another to pymavlink, so it is refused.

From one `send` to the next is a step of the loop. What is received in it is bounded, whatever
arrives (`companion/mavlink/intake.py`); the address that is sent to has a share of its own. With a
key, frames are signed and verified here (`companion/mavlink/signing.py`), before anything is
learned from them.
"""

from __future__ import annotations

import logging
import re
import select
import socket
import time
from dataclasses import dataclass

from companion.errors import LinkError
from companion.flight_events.event import FlightEvent
from companion.flight_events.hosting import DatagramsDropped, FramesRefused
from companion.mavlink.intake import LONGEST, READS, Address, Intake
from companion.mavlink.signing import Signing
from companion.vehicle.autopilot_address import AutopilotAddress

URL = re.compile(r"(?P<scheme>[a-z]+):(?://)?((?P<host>[^:/]*):)?(?P<port>\d+)/?$")
SCHEMES = ("udp", "udpin", "udpout")
MAX_PORT = 65535
MAVLINK2_MAGIC = b"\xfd"
RECEIVE_BUFFER = 1 << 20
LEAST_IN_BUFFER = 256
"""Bytes that a datagram takes in the receive buffer at least, with what the system keeps of it."""
HOSTS_NAMED = 8
"""So many that were heard are named; a flood may come from any number."""

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Endpoint:
    """One end of a UDP link."""

    is_listening: bool
    host: str
    port: int

    def __str__(self) -> str:
        return f"{'udpin' if self.is_listening else 'udpout'}://{self.host}:{self.port}"


def parse_url(url: str) -> Endpoint:
    """The endpoint of a URL such as udpin://0.0.0.0:14540 or udpout:192.168.1.10:14580.

    Raises:
        LinkError: with the URL that was perhaps meant.
    """
    match = URL.match(url)
    if match is None or int(match["port"]) > MAX_PORT or match["scheme"] not in SCHEMES:
        raise LinkError(
            f"cannot connect to {url}\n"
            "    write udpin://0.0.0.0:14540 to listen, or udpout://HOST:PORT to send first"
        )
    scheme, port = match["scheme"], int(match["port"])
    listening = Endpoint(True, match["host"] or "0.0.0.0", port)
    sending = Endpoint(False, match["host"] or "127.0.0.1", port)
    if scheme == "udp":
        raise LinkError(
            f"udp: is ambiguous in {url}\n"
            f"    write {listening} to listen on that port, as for PX4 on 14540\n"
            f"    or {sending} to send to that address first"
        )
    return listening if scheme == "udpin" else sending


class UdpLink:
    """Datagrams to and from one vehicle.

    Args:
        endpoint: our end of the link.
        signing: signs and verifies the frames; None for a link without signatures.

    Raises:
        LinkError: the port cannot be opened.
    """

    def __init__(self, endpoint: Endpoint, signing: Signing | None = None) -> None:
        self.endpoint = endpoint
        self._signing = signing
        self._begun_s = time.monotonic()
        self._hosts: set[str] = set()
        self._taken = self._mavlink = 0
        self._intake = Intake()
        self._autopilot = AutopilotAddress()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        self._called: Address | None = None
        try:
            if endpoint.is_listening:
                self._socket.bind((endpoint.host, endpoint.port))
            else:
                self._called = (socket.gethostbyname(endpoint.host), endpoint.port)
        except OSError as error:
            self._socket.close()
            if not endpoint.is_listening:
                raise LinkError(f"cannot find {endpoint.host}: {error.strerror}") from error
            raise LinkError(
                f"cannot listen on {endpoint}: {error.strerror}\n"
                "    another program has the port; only one can, and QGroundControl needs 14550"
            ) from error

    def receive(self) -> list[bytes]:
        """The datagrams that have arrived, as far as this step takes them in."""
        datagrams: list[bytes] = []
        for _ in range(READS):
            try:
                datagram, sender = self._socket.recvfrom(LONGEST + 1)
            except BlockingIOError:
                break
            except ConnectionError:  # an ICMP "nobody listens" of an earlier send
                continue
            if self._intake.takes(sender, datagram, self._peer):
                self._note(sender, datagram)
                for accepted in self._verified(datagram):
                    datagrams.append(accepted)
                    self._autopilot.hear(time.monotonic(), sender, accepted)
        return datagrams

    def discard(self) -> None:
        """Drops what has arrived so far, as it speaks of the past."""
        for _ in range(RECEIVE_BUFFER // LEAST_IN_BUFFER):
            try:
                self._socket.recv(1)
            except BlockingIOError:
                return
            except ConnectionError:
                continue

    def send(self, datagrams: list[bytes]) -> None:
        """Sends to the vehicle; what the network does not take is lost, as on a radio."""
        self._intake.begin_step()
        address = self._peer
        if address is None:
            return
        if self._signing is not None:
            datagrams = self._signing.send(time.monotonic() - self._begun_s, datagrams)
        for datagram in datagrams:
            try:
                self._socket.sendto(datagram, address)
            except OSError:
                continue

    @property
    def _peer(self) -> Address | None:
        return self._called or self._autopilot.address

    def _verified(self, datagram: bytes) -> list[bytes]:
        if self._signing is None:
            return [datagram]
        return self._signing.receive(time.monotonic() - self._begun_s, [datagram])

    def _note(self, sender: Address, datagram: bytes) -> None:
        self._taken += 1
        self._mavlink += datagram[:1] == MAVLINK2_MAGIC
        if sender[0] not in self._hosts and len(self._hosts) < HOSTS_NAMED:
            self._hosts.add(sender[0])
            log.debug("first datagram from %s:%d, %d bytes", *sender, len(datagram))

    def fileno(self) -> int:
        """Of the socket, for those who wait for several."""
        return self._socket.fileno()

    def wait(self, timeout_s: float) -> bool:
        """Waits until something has arrived, at most so many wall-clock seconds; whether it has."""
        return bool(select.select([self._socket], [], [], max(0.0, timeout_s))[0])

    def news(self) -> list[FlightEvent]:
        """How much was dropped and refused so far, when that is news."""
        events: list[FlightEvent] = []
        if dropped := self._intake.news():
            events.append(DatagramsDropped(dropped))
        if self._signing is not None and (refused := self._signing.news()):
            events.append(FramesRefused(*refused))
        return events

    def account(self) -> str:
        """What was heard so far, in words."""
        if not self._taken:
            return "nothing arrived"
        system = self._autopilot.system
        autopilot = "no autopilot" if system is None else f"the autopilot of {system}"
        account = (
            f"{self._taken} packets came from {', '.join(sorted(self._hosts))}, "
            f"{self._mavlink or 'none'} of them MAVLink 2; {autopilot} was heard"
        )
        if self._signing is None or not any(self._signing.refused):
            return account
        return f"{account}; refused: {self._signing.refused}"

    def close(self) -> None:
        """Frees the port."""
        self._socket.close()
