"""The door through which programs on board report to the companion (`sitl/world/reporter.py`).

It sends to the address at which the companion listens by `--events`.
"""

from __future__ import annotations

import socket
from collections.abc import Iterable
from contextlib import suppress

from companion.errors import LinkError


class ReportSender:
    """Sends each report as a datagram; if nobody listens it is lost, as on board.

    Args:
        address: `unix:PATH` or `udpin:HOST:PORT`, as given to the companion.

    Raises:
        LinkError: the address has another form.
    """

    def __init__(self, address: str) -> None:
        scheme, _, rest = address.partition(":")
        rest = rest.removeprefix("//")
        host, _, port = rest.rpartition(":")
        self._target: str | tuple[str, int]
        if scheme == "unix" and rest:
            family, self._target = socket.AF_UNIX, rest
        elif scheme == "udpin" and port.isdecimal() and 0 < int(port) < 1 << 16:
            family, self._target = socket.AF_INET, (host or "127.0.0.1", int(port))
        else:
            raise LinkError(
                f"cannot send reports to {address}: write unix:PATH or udpin:HOST:PORT, as the "
                f"companion's --events"
            )
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        self._socket.setblocking(False)

    def send(self, reports: Iterable[bytes]) -> None:
        """Sends reports, one datagram each."""
        for report in reports:
            with suppress(OSError):  # nobody listens yet, or the listener is too slow
                self._socket.sendto(report, self._target)

    def close(self) -> None:
        """Closes the socket."""
        self._socket.close()
