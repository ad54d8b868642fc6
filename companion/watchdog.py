"""Tells the service manager that the loop runs, so that it restarts a companion that hangs.

The setpoints of a hanging loop stop by themselves; the restart serves what comes after. Without a
service manager nothing is sent.

Source: sd_notify(3), sd_watchdog_enabled(3) of systemd.
"""

from __future__ import annotations

import socket
from collections.abc import Mapping
from contextlib import suppress

BEATS = 4
"""Number of messages within the service manager's time limit."""


class Watchdog:
    """Sends messages to the service manager that the environment names.

    >>> Watchdog({}).beat(0.0)  # there is none

    Args:
        environment: only NOTIFY_SOCKET and WATCHDOG_USEC are read.
    """

    def __init__(self, environment: Mapping[str, str]) -> None:
        self._address = environment.get("NOTIFY_SOCKET", "").replace("@", "\0", 1)
        self._period_s = float(environment.get("WATCHDOG_USEC", "0")) / 1e6 / BEATS
        self._next_s: float | None = None
        self._socket = None
        if self._address:
            self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
            self._socket.setblocking(False)

    def beat(self, now_s: float) -> None:
        """Reports that the loop runs; the first call reports that the program is ready.

        Args:
            now_s: the time of a monotonic clock.
        """
        if self._next_s is None:
            self._tell("READY=1")
            self._next_s = now_s
        if self._period_s and now_s >= self._next_s:
            self._tell("WATCHDOG=1")
            self._next_s = now_s + self._period_s

    def close(self) -> None:
        """Reports that the program ends."""
        self._tell("STOPPING=1")
        if self._socket is not None:
            self._socket.close()

    def _tell(self, state: str) -> None:
        if self._socket is not None:
            with suppress(OSError):  # the receiver is busy or gone: the flight continues
                self._socket.sendto(state.encode(), self._address)
