"""A campaign: rows are flown by an engine, kept as they come, and become one table.

Whoever needs rows asks `Campaign.flown` for them. Those that are in the folder already are not
flown again, so that a campaign that was cut off goes on by doing everything once more.
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
"""Told of each row when it is back."""


class Interrupted(CompanionError):
    """The user has stopped a campaign; what was flown is kept."""


class Campaign:
    """Rows of one kit, in one folder.

    Args:
        kit: what is flown.
        engine: who flies.
        folder: where rows are kept.
        header: of the table.
        on_row: told of each row when it is back.
        on_kept: told of each row that was there already.
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
        """All that were flown, in order of their index."""
        return tuple(self._file.rows[index] for index in sorted(self._file.rows))

    def flown(self, rows: Sequence[Row]) -> tuple[FlownRow, ...]:
        """The rows, flown, in their own order.

        Raises:
            Interrupted: the user has pressed Ctrl-C; rows under way were waited for.
            MissionError: a row that was there already is another one.
            NotWritten: a row cannot be kept.
            LinkError: the cluster is gone.
            CompanionError: a worker would fly other bytes.
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
        """The folder is free."""
        self._file.close()

    def _check(self, row: Row, kept: Row) -> None:
        if row != kept:
            raise MissionError(
                f"row {row.index} of {self.folder} was edited: it is none of this campaign",
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
            pass  # once more: these rows are dropped


def random_rows(kit: Kit, seed: int, runs: int) -> list[Row]:
    """The rows of a campaign that nothing has chosen."""
    return [random_row(kit.factors, seed, index) for index in range(runs)]
