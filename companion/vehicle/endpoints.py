"""Parses the URL of a link to a vehicle; each kind of link has a class.

    udpin://0.0.0.0:14540          binds a port; the autopilot sends to it, as PX4 SITL does
    udpout://192.168.1.10:14580    sends to an address
    tcpout://192.168.1.10:5760     connects to a server, again and again until it is there
    serial:///dev/ttyTHS1:921600   opens a serial port at a speed in baud; likewise

A bare `udp` is refused, because MAVSDK and pymavlink give it different meanings. MAVSDK reads the
same URLs.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import ClassVar

from companion.errors import AddressError

MAX_PORT = 65535
HELP = """\
    write udpin://0.0.0.0:14540 to listen, or udpout://HOST:PORT to send first,
    tcpout://HOST:PORT for a server, serial:///dev/ttyTHS1:921600 for a serial port"""

_HOST_AND_PORT = re.compile(r"(?:(?P<host>[^:/]*):)?(?P<port>\d+)/?")
_DEVICE_AND_BAUD = re.compile(r"(?P<device>[^:]+):(?P<baud>\d+)")


@dataclass(frozen=True, slots=True)
class NetworkAddress:
    """A host and a port."""

    scheme: ClassVar[str]
    host: str
    port: int

    def __str__(self) -> str:
        return f"{self.scheme}://{self.host}:{self.port}"

    @property
    def name(self) -> str:
        """A short name, used in file names."""
        return str(self.port)


class UdpPort(NetworkAddress):
    """A UDP port to bind."""

    __slots__ = ()
    scheme = "udpin"


class UdpPeer(NetworkAddress):
    """A UDP address to send to."""

    __slots__ = ()
    scheme = "udpout"


class TcpServer(NetworkAddress):
    """A TCP server to connect to."""

    __slots__ = ()
    scheme = "tcpout"


@dataclass(frozen=True, slots=True)
class SerialPort:
    """A serial port and its speed."""

    device: str
    baud: int

    def __str__(self) -> str:
        return f"serial://{self.device}:{self.baud}"

    @property
    def name(self) -> str:
        """A short name, used in file names."""
        return self.device.rpartition("/")[2]


Endpoint = UdpPort | UdpPeer | TcpServer | SerialPort

OFFBOARD_PORT = 14540
"""The UDP port to which PX4 sends its offboard link."""
OFFBOARD_URL = str(UdpPort("0.0.0.0", OFFBOARD_PORT))


def parse_url(url: str) -> Endpoint:
    """The endpoint of a URL such as udpin://0.0.0.0:14540 or serial:///dev/ttyTHS1:921600.

    Raises:
        AddressError: the message suggests the URL that was probably meant.
    """
    scheme, _, rest = url.partition(":")
    rest = rest.removeprefix("//")
    if scheme == "serial":
        match = _DEVICE_AND_BAUD.fullmatch(rest)
        if match is not None and int(match["baud"]) > 0:
            return SerialPort(match["device"], int(match["baud"]))
        device = rest.partition(":")[0] or "/dev/ttyTHS1"
        raise AddressError(
            f"cannot connect to {url}\n"
            f"    write {SerialPort(device, 921600)}, with the speed of the port in baud"
        )
    elif match := _HOST_AND_PORT.fullmatch(rest):
        host, port = match["host"], int(match["port"])
        here, there = UdpPort(host or "0.0.0.0", port), UdpPeer(host or "127.0.0.1", port)
        if port <= MAX_PORT:
            match scheme:
                case "udpin":
                    return here
                case "udpout":
                    return there
                case "tcpout" | "tcp":
                    return TcpServer(there.host, port)
                case "udp":
                    raise AddressError(
                        f"udp: is ambiguous in {url}\n"
                        f"    write {here} to listen on that port, as for PX4 on 14540\n"
                        f"    or {there} to send to that address first"
                    )
    if url.startswith("/dev/"):
        device, _, baud = url.partition(":")
        meant = SerialPort(device, int(baud) if baud.isdecimal() else 57600)
        raise AddressError(f"cannot connect to {url}\n    write {meant}, with its speed in baud")
    raise AddressError(f"cannot connect to {url}\n{HELP}")
