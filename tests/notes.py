"""A recorder for flights of which only the reports matter."""

from __future__ import annotations

from companion.acting.report import Report
from companion.geometry import Ned


class Notes:
    """A recorder that keeps what people are told.

    Attributes:
        texts: of the reports so far.
    """

    def __init__(self) -> None:
        self.texts: list[str] = []

    def report(self, report: Report) -> None:
        if report.is_told:
            self.texts.append(report.text)

    def packets(self, now_s: float, datagrams: list[bytes]) -> None:
        """Kept nowhere."""

    def position(self, now_s: float, position: Ned) -> None:
        """The same."""
