"""The socket at which other programs on board report events (`detections.py`).

A door. By default a Unix datagram socket: it cannot be reached from another machine, and its file
says who may write to it. Or a UDP port of this machine, which any of its programs may send to.
"""

from __future__ import annotations

import os
import re
import socket
import stat
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path

from companion.errors import LinkError
from companion.vehicle.detections import LONGEST, MOST

MODE = 0o660
HELP = """\
    write unix:/run/companion/events, or udpin:127.0.0.1:14600 for a UDP port of this machine"""
_UDP = re.compile(r"(?://)?(?P<host>[^:/]*):(?P<port>\d+)")


class ReportPort:
    """A socket that is bound; its file is taken away when it is closed.

    Args:
        address: `unix:PATH` or `udpin:HOST:PORT`.

    Raises:
        LinkError: it cannot be bound, or is no such address.
    """

    def __init__(self, address: str) -> None:
        self._path: Path | None = None
        scheme, _, rest = address.partition(":")
        try:
            if scheme == "unix" and rest:
                self._socket = self._bound_to_path(Path(rest.removeprefix("//")))
            elif scheme == "udpin" and (match := _UDP.fullmatch(rest)):
                self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
                self._socket.bind((match["host"] or "127.0.0.1", int(match["port"])))
            else:
                raise LinkError(f"cannot hear reports on {address}\n{HELP}")
        except (OSError, OverflowError) as error:
            raise LinkError(f"cannot hear reports on {address}: {error}\n{HELP}") from error
        self._socket.setblocking(False)

    def receive(self) -> list[bytes]:
        """What was reported since, `MOST` datagrams at most; the next tick has the rest."""
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
        """A socket with a file; one that a program which was killed has left is replaced."""
        unix = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        if path.exists() and stat.S_ISSOCK(path.stat().st_mode) and not _is_heard(path):
            path.unlink()
        unix.bind(str(path))
        self._path = path
        os.chmod(path, MODE)
        return unix


@contextmanager
def reports_at(address: str | None) -> Iterator[ReportPort | None]:
    """The port at an address while the context lasts; none without an address."""
    if address is None:
        yield None
        return
    with closing(ReportPort(address)) as port:
        yield port


def _is_heard(path: Path) -> bool:
    """Whether somebody listens at a socket's file."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(str(path))
        except OSError:
            return False
    return True
