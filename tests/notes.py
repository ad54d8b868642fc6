"""A recorder for flights of which only the reports matter."""

from __future__ import annotations

from happened import Happened

from companion.acting.journal import NoJournal
from companion.flight_events.event import Stamped
from companion.geometry import Ned
from companion.vehicle.run_clocks import ClockReading


class Notes(Happened):
    """A recorder that keeps what happens."""

    journal = NoJournal()
    name = ""

    def __init__(self) -> None:
        self.reports: list[Stamped] = []

    def report(self, stamped: Stamped) -> None:
        self.reports.append(stamped)

    def clocks(self, reading: ClockReading) -> None:
        """Not read."""

    def packets(self, now_s: float, datagrams: list[bytes]) -> None:
        """Kept nowhere."""

    def position(self, now_s: float, position: Ned) -> None:
        """The same."""
