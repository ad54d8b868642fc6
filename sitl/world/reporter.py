"""A program on board that reports what it sees, to the companion's `--events` port.

What it reports, and when, are the scenario's events: each `report` is one datagram, a JSON object.
It goes beside MAVLink, on the machine on which the companion runs: in lockstep the harness hands it
on, in real time `sitl/link/report_sender.py` does.
"""

from __future__ import annotations

import json
from collections.abc import Mapping


class Reporter:
    """What is reported and was not taken yet."""

    def __init__(self) -> None:
        self._datagrams: list[bytes] = []

    def report(self, values: Mapping[str, object]) -> None:
        """Reports some values."""
        self._datagrams.append(json.dumps(values).encode())

    def take(self) -> list[bytes]:
        """The datagrams since the last call."""
        datagrams, self._datagrams = self._datagrams, []
        return datagrams
