"""Carries bytes to and from a vehicle, with a class for each kind of link: UDP, and streams.

A door: it opens sockets and serial ports, and reads the wall clock. `link.py` uses the datagrams.
"""

from __future__ import annotations

import errno
import os
import select
import socket
import time
from collections.abc import Iterator
from typing import Protocol

import serial

from companion.errors import LinkError
from companion.flight_events.event import FlightEvent
from companion.flight_events.hosting import PortLost, PortRestored
from companion.mavlink.intake import LONGEST, READS, Address
from companion.mavlink.stream_frames import StreamFrames
from companion.vehicle.endpoints import Endpoint, SerialPort, TcpServer, UdpPeer, UdpPort

RECEIVE_BUFFER = 1 << 20
LEAST_IN_BUFFER = 256
"""Bytes that a datagram occupies in the receive buffer at least, with the system's overhead."""
READ_AT_ONCE = 1 << 14
"""Bytes of a stream in a step: more than a line of 921,600 baud carries in a tenth of a second."""
TRY_AGAIN_S = 1.0
_LISTENING = {
    errno.EADDRINUSE: "\n    another program has the port; only one can, and QGroundControl needs "
    "14550\n    companion doctor says which",
    errno.EACCES: "\n    ports below 1024 are the system's: choose a higher one",
    errno.EADDRNOTAVAIL: "\n    this machine has no such address; 0.0.0.0 stands for all it has",
}
"""Advice for a port that cannot be opened, by error number."""


class Transport(Protocol):
    """Carries datagrams.

    Attributes:
        peer: the address to send to, if it is known before anybody was heard.
    """

    peer: Address | None

    def receive(self) -> Iterator[tuple[bytes, Address]]:
        """What has arrived, with its senders; bounded, and without waiting."""

    def discard(self) -> None:
        """Drops all that has arrived so far."""

    def send(self, datagram: bytes, address: Address) -> None:
        """Sends a whole datagram, or nothing; never waits."""

    def wait(self, timeout_s: float) -> bool:
        """Waits until something arrives, at most `timeout_s` of wall-clock time; returns whether it
        has.
        """

    def news(self) -> list[FlightEvent]:
        """What became of the line since the last call."""

    def close(self) -> None:
        """Frees the port."""


def open_transport(endpoint: Endpoint) -> Transport:
    """The transport to an endpoint.

    Raises:
        LinkError: a port cannot be bound, or a host is not known. For a server or a serial port
            that is not there there is no error: the transport keeps trying to open it.
    """
    if isinstance(endpoint, UdpPort | UdpPeer):
        return Udp(endpoint)
    return Stream(endpoint)


def check_port(endpoint: Endpoint) -> None:
    """Raises an error if another program has a UDP port.

    Raises:
        LinkError: it cannot be bound.
    """
    if isinstance(endpoint, UdpPort):
        Udp(endpoint).close()


class Udp:
    """A UDP socket."""

    def __init__(self, endpoint: UdpPort | UdpPeer) -> None:
        self.peer: Address | None = None
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, RECEIVE_BUFFER)
        try:
            if isinstance(endpoint, UdpPort):
                self._socket.bind((endpoint.host, endpoint.port))
            else:
                self.peer = (address_of(endpoint.host), endpoint.port)
        except OSError as error:
            self._socket.close()
            advice = _LISTENING.get(error.errno or 0, "")
            raise LinkError(f"cannot listen on {endpoint}: {error.strerror}{advice}") from error
        except LinkError:
            self._socket.close()
            raise

    @property
    def address(self) -> Address:
        """That of the socket itself."""
        host, port = self._socket.getsockname()
        return host, port

    def receive(self) -> Iterator[tuple[bytes, Address]]:
        """The datagrams that have arrived; those longer than the limit are cut off behind it."""
        for _ in range(READS):
            try:
                yield self._socket.recvfrom(LONGEST + 1)
            except BlockingIOError:
                return
            except ConnectionError:  # an ICMP "nobody listens" of an earlier send
                continue

    def discard(self) -> None:
        """Drops all that has arrived, even more than a step takes."""
        for _ in range(RECEIVE_BUFFER // LEAST_IN_BUFFER):
            try:
                self._socket.recv(1)
            except BlockingIOError:
                return
            except ConnectionError:
                continue

    def send(self, datagram: bytes, address: Address) -> None:
        """Sends a datagram; what the network does not take is lost, as on a radio."""
        try:
            self._socket.sendto(datagram, address)
        except OSError:
            return

    def wait(self, timeout_s: float) -> bool:
        """Waits as `Transport.wait` does."""
        return bool(select.select([self._socket], [], [], max(0.0, timeout_s))[0])

    def news(self) -> list[FlightEvent]:
        """None: a UDP socket has no news."""
        return []

    def close(self) -> None:
        """Frees the port."""
        self._socket.close()


class Stream:
    """A serial port, or a TCP connection; while it is not there, it is opened again once a second.

    A datagram is one frame. A frame for which the line has no room is lost; the rest of a frame
    that has been begun is sent first.
    """

    def __init__(self, endpoint: TcpServer | SerialPort) -> None:
        self.peer: Address | None = (str(endpoint), 0)
        self._endpoint = endpoint
        self._host = address_of(endpoint.host) if isinstance(endpoint, TcpServer) else ""
        self._line: socket.socket | serial.Serial | None = None
        self._frames = StreamFrames()
        self._unsent = b""
        self._try_s = 0.0
        self._is_broken = False
        self._news: list[FlightEvent] = []

    def receive(self) -> Iterator[tuple[bytes, Address]]:
        """The frames that are complete by now."""
        assert self.peer is not None
        for frame in self._frames.take(self._read()):
            yield frame, self.peer

    def discard(self) -> None:
        """Drops all that has arrived; the system buffers less of a line than this reads."""
        for _ in range(RECEIVE_BUFFER // READ_AT_ONCE):
            if not self._read():
                break
        self._frames = StreamFrames()

    def send(self, datagram: bytes, address: Address) -> None:
        """Sends as `Transport.send` does."""
        if not self._flush():
            return
        self._unsent = datagram
        if not self._flush() and self._unsent == datagram:
            self._unsent = b""

    def wait(self, timeout_s: float) -> bool:
        """Waits as `Transport.wait` does."""
        if self._line is None:
            time.sleep(max(0.0, timeout_s))
            return False
        return bool(select.select([self._line], [], [], max(0.0, timeout_s))[0])

    def news(self) -> list[FlightEvent]:
        """Reports once that the line is broken, and once that it is there again."""
        news, self._news = self._news, []
        return news

    def close(self) -> None:
        """Frees the port."""
        if self._line is not None:
            self._line.close()
            self._line = None

    def _read(self) -> bytes:
        try:
            line = self._opened()
            if line is None or not select.select([line], [], [], 0.0)[0]:
                return b""
            if data := os.read(line.fileno(), READ_AT_ONCE):
                self._mend()
                return data
            raise ConnectionResetError(None, "the other end has closed it")
        except BlockingIOError:
            return b""
        except OSError as error:
            self._break(error)
            return b""

    def _flush(self) -> bool:
        """Writes what is left of a frame; returns whether the line is ready for another."""
        try:
            while self._unsent and self._line is not None:
                self._unsent = self._unsent[os.write(self._line.fileno(), self._unsent) :]
        except BlockingIOError:
            return False
        except OSError as error:
            self._break(error)
        return self._line is not None

    def _opened(self) -> socket.socket | serial.Serial | None:
        if self._line is None and time.monotonic() >= self._try_s:
            self._try_s = time.monotonic() + TRY_AGAIN_S
            self._line = self._open()
        return self._line

    def _open(self) -> socket.socket | serial.Serial:
        """Opens the line without waiting.

        Raises:
            OSError: it cannot be opened.
        """
        if isinstance(self._endpoint, SerialPort):
            return serial.Serial(self._endpoint.device, self._endpoint.baud, exclusive=True)
        line = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        line.setblocking(False)
        line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        line.connect_ex((self._host, self._endpoint.port))  # a failure is read from it
        return line

    def _break(self, error: OSError) -> None:
        self.close()
        self._unsent, self._frames = b"", StreamFrames()
        if not self._is_broken:
            self._is_broken = True
            self._news.append(PortLost(str(self._endpoint), error.strerror or str(error)))

    def _mend(self) -> None:
        if self._is_broken:
            self._is_broken = False
            self._news.append(PortRestored(str(self._endpoint)))


def address_of(host: str) -> str:
    """The IP address of a host.

    Raises:
        LinkError: the name cannot be resolved.
    """
    try:
        return socket.gethostbyname(host)
    except OSError as error:
        raise LinkError(f"cannot find {host}: {error.strerror}") from error
