"""The socket on which other programs on board report events (`detections.py`).

A door. By default it is a Unix datagram socket: no other machine can reach it, and the permissions
of its file determine who may write. It may also be a UDP port of this machine, to which any local
program can send.
"""

from __future__ import annotations

import os
import re
import socket
import stat
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path

from companion.errors import AddressError, LinkError
from companion.vehicle.detections import LONGEST, MOST

MODE = 0o660
HELP = """\
    write unix:/run/companion/events, or udpin:127.0.0.1:14600 for a UDP port of this machine"""
_UDP = re.compile(r"(?://)?(?P<host>[^:/]*):(?P<port>\d+)")


def place_of(address: str) -> Path | tuple[str, int]:
    """The path, or host and port, of an address.

    >>> place_of("unix:/run/events"), place_of("udpin::14600")
    (PosixPath('/run/events'), ('127.0.0.1', 14600))

    Raises:
        AddressError: it is neither unix:PATH nor udpin:HOST:PORT.
    """
    scheme, _, rest = address.partition(":")
    if scheme == "unix" and rest:
        return Path(rest.removeprefix("//"))
    if scheme == "udpin" and (match := _UDP.fullmatch(rest)):
        return match["host"] or "127.0.0.1", int(match["port"])
    raise AddressError(f"cannot hear reports on {address}\n{HELP}")


class ReportPort:
    """A bound socket; its file is removed when it is closed.

    Args:
        address: `unix:PATH` or `udpin:HOST:PORT`.

    Raises:
        LinkError: it cannot be bound.
        AddressError: the address has neither form.
    """

    def __init__(self, address: str) -> None:
        self._path: Path | None = None
        place = place_of(address)
        try:
            if isinstance(place, Path):
                self._socket = self._bound_to_path(place)
            else:
                self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
                self._socket.bind(place)
        except (OSError, OverflowError) as error:
            raise LinkError(f"cannot hear reports on {address}: {error}\n{HELP}") from error
        self._socket.setblocking(False)

    def receive(self) -> list[bytes]:
        """What was reported since the last call, at most `MOST` datagrams; the next call has the
        rest.
        """
        datagrams: list[bytes] = []
        for _ in range(MOST):
            try:
                datagrams.append(self._socket.recv(LONGEST + 1))
            except OSError:  # nothing more
                break
        return datagrams

    def close(self) -> None:
        """Frees the port."""
        self._socket.close()
        if self._path is not None:
            with suppress(OSError):
                self._path.unlink()

    def _bound_to_path(self, path: Path) -> socket.socket:
        """A socket with a file; replaces the file of a program that was killed."""
        unix = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        if path.exists() and stat.S_ISSOCK(path.stat().st_mode) and not _is_heard(path):
            path.unlink()
        unix.bind(str(path))
        self._path = path
        os.chmod(path, MODE)
        return unix


@contextmanager
def reports_at(address: str | None) -> Iterator[ReportPort | None]:
    """Opens the port at an address while the context lasts; None without an address."""
    if address is None:
        yield None
        return
    with closing(ReportPort(address)) as port:
        yield port


def _is_heard(path: Path) -> bool:
    """Whether a program listens at a socket's file."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(str(path))
        except OSError:
            return False
    return True
