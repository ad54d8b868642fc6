"""A program on board that reports what it sees to the companion's `--events` port.

The scenario's events say what it reports and when: each `report` is one datagram, a JSON object. It
does not use MAVLink, and runs on the companion's machine. In lockstep the harness passes the
datagrams on; in real time `sitl/link/report_sender.py` does.
"""

from __future__ import annotations

import json
from collections.abc import Mapping


class Reporter:
    """The reports that have not been taken yet."""

    def __init__(self) -> None:
        self._datagrams: list[bytes] = []

    def report(self, values: Mapping[str, object]) -> None:
        """Reports some values."""
        self._datagrams.append(json.dumps(values).encode())

    def take(self) -> list[bytes]:
        """The datagrams since the last call."""
        datagrams, self._datagrams = self._datagrams, []
        return datagrams
