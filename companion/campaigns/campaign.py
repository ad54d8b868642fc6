"""A campaign: an engine flies rows, a folder keeps them, and they become one table.

Callers ask `Campaign.flown` for rows. Rows that the folder already has are not flown again, so an
interrupted campaign is continued by running the same command again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from companion.campaigns import table
from companion.campaigns.kit import Kit
from companion.campaigns.outcomes import FlownRow
from companion.campaigns.processes import RowEngine
from companion.campaigns.row_file import RowFile
from companion.campaigns.rows import Row, random_row
from companion.errors import CompanionError, MissionError

OnRow = Callable[[FlownRow], None]
"""Called with each row when it has been flown."""


class Interrupted(CompanionError):
    """The user has stopped a campaign; the rows flown so far are kept."""


class Campaign:
    """The rows of one kit, in one folder.

    Args:
        kit: mission and scenario.
        engine: flies the rows.
        folder: keeps the rows.
        header: the header of the table.
        on_row: called with each row when it has been flown.
        on_kept: called with each row that the folder already had.
    """

    def __init__(
        self,
        kit: Kit,
        engine: RowEngine,
        folder: Path,
        header: dict[str, str],
        on_row: OnRow,
        on_kept: OnRow = lambda flown: None,
    ) -> None:
        self.kit, self.folder, self.header = kit, folder, header
        self._engine, self._on_row, self._on_kept = engine, on_row, on_kept
        self._file = RowFile(folder, header)

    @property
    def rows(self) -> tuple[FlownRow, ...]:
        """All rows flown so far, in the order of their index."""
        return tuple(self._file.rows[index] for index in sorted(self._file.rows))

    def flown(self, rows: Sequence[Row]) -> tuple[FlownRow, ...]:
        """Flies the rows that are missing; returns all, in the given order.

        Raises:
            Interrupted: the user has pressed Ctrl-C; rows under way were completed.
            MissionError: the folder has another row with the same index.
            NotWritten: a row cannot be written.
            LinkError: the cluster does not answer any more.
            CompanionError: a worker has another environment, so its flights would differ.
        """
        kept = self._file.rows
        for row in rows:
            if row.index in kept:
                self._check(row, kept[row.index].row)
                self._on_kept(kept[row.index])
        try:
            for flown in self._engine.fly(row for row in rows if row.index not in kept):
                self._keep(flown)
        except KeyboardInterrupt:
            self._keep_what_is_under_way()
            raise Interrupted("stopped") from None
        return tuple(kept[row.index] for row in rows)

    def write_table(self) -> Path:
        """Writes the table of all rows; returns its path."""
        paths = [factor.path for factor in self.kit.factors]
        path = self.folder / table.NAME
        table.write_whole(path, table.table_text(self.header, paths, self.rows))
        return path

    def close(self) -> None:
        """Releases the folder."""
        self._file.close()

    def _check(self, row: Row, kept: Row) -> None:
        if row != kept:
            raise MissionError(
                f"row {row.index} of {self.folder} was edited: it does not belong to this campaign",
                hint="take another folder with --out",
            )

    def _keep(self, flown: FlownRow) -> None:
        self._file.add(flown)
        self._on_row(flown)

    def _keep_what_is_under_way(self) -> None:
        try:
            for flown in self._engine.finish():
                self._keep(flown)
        except KeyboardInterrupt:
            pass  # a second Ctrl-C: the rows under way are dropped


def random_rows(kit: Kit, seed: int, runs: int) -> list[Row]:
    """The rows of a campaign that are drawn at random."""
    return [random_row(kit.factors, seed, index) for index in range(runs)]
