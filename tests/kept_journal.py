"""A journal in memory."""

from __future__ import annotations

from companion.acting.journal import JournalEntry


class KeptJournal:
    """Keeps entries; a test may say that they are not on the disk yet.

    Attributes:
        entries: with their times.
        is_kept: whether all of them are on the disk.
    """

    def __init__(self) -> None:
        self.entries: list[tuple[float, JournalEntry]] = []
        self.is_kept = True

    def note(self, now_s: float, entry: JournalEntry) -> None:
        self.entries.append((now_s, entry))

    @property
    def noted(self) -> list[JournalEntry]:
        """The entries without their times."""
        return [entry for _, entry in self.entries]
