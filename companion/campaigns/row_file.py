"""The rows of a campaign on disk: DIR/rows.jsonl.

1. The first line is the header; each row is a line of its own.
2. Each row is written to the disk (fsync) before the campaign waits for the next one. So if
   anything ends the campaign, such as a full disk, only the rows under way are lost.
3. An incomplete last line is dropped; a damaged line before it is refused.
4. Two campaigns cannot write to one folder.
"""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from companion.campaigns.outcomes import FlownRow
from companion.errors import CompanionError, MissionError

NAME = "rows.jsonl"


class NotWritten(CompanionError):
    """A file of a campaign cannot be written, as on a full disk; earlier rows are kept."""

    def __init__(self, path: Path, error: OSError) -> None:
        super().__init__(f"{path} cannot be written: {error.strerror}")


class RowFile:
    """The file of a campaign, open and locked.

    Args:
        folder: the folder of the campaign.
        header: all that its rows depend on.

    Attributes:
        rows: the rows flown so far, by index.

    Raises:
        CompanionError: another campaign writes to the folder.
        MissionError: the folder has rows of another campaign, or a damaged line.
        NotWritten: the file cannot be written.
    """

    def __init__(self, folder: Path, header: Mapping[str, str]) -> None:
        self._path = folder / NAME
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file = self._path.open("a+b", buffering=0)
        except OSError as error:
            raise NotWritten(self._path, error) from error
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            self._file.close()
            raise CompanionError(f"another campaign is writing to {folder}") from error
        try:
            self.rows = self._begin(folder, header)
        except CompanionError:
            self.close()
            raise

    def _begin(self, folder: Path, header: Mapping[str, str]) -> dict[int, FlownRow]:
        """The rows of the same campaign; an incomplete last line is dropped."""
        before, entries, whole = _read(self._path)
        if before is not None and before != dict(header):
            raise _other_campaign(folder, before, header)
        try:
            flown = [FlownRow.of_json(entry) for entry in entries]
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise MissionError(
                f"{self._path} holds something that is not a row of a campaign ({error!r})",
                hint="take another folder with --out",
            ) from error
        self._file.truncate(whole)
        if before is None:
            self._write(dict(header))
        return {each.row.index: each for each in flown}

    def add(self, flown: FlownRow) -> None:
        """Writes a row.

        Raises:
            NotWritten: it cannot be written; at most a part of its line is in the file.
        """
        self._write(flown.as_json())
        self.rows[flown.row.index] = flown

    def close(self) -> None:
        """Releases the folder for another campaign."""
        self._file.close()

    def _write(self, entry: Mapping[str, object]) -> None:
        line = json.dumps(entry).encode() + b"\n"
        try:
            while line:
                line = line[self._file.write(line) :]
            os.fsync(self._file.fileno())
        except OSError as error:
            raise NotWritten(self._path, error) from error


def header_in(folder: Path, key: str) -> dict[str, str]:
    """The header of the campaign in a folder.

    Args:
        folder: the folder of the campaign.
        key: a line that the header of this kind of campaign has.

    Raises:
        MissionError: there is no campaign, or one of another kind.
    """
    path = folder / NAME
    header = _read(path)[0] if path.is_file() else None
    if header is None:
        raise MissionError(f"{folder} holds no campaign: {NAME} is missing or has no header")
    if key not in header:
        raise MissionError(
            f"{folder} was made by another command: its header has no {key}",
            hint="go on with the command that began it: campaign or falsify",
        )
    return header


def _read(path: Path) -> tuple[dict[str, str] | None, list[dict[str, Any]], int]:
    """The header, the rows as written, and the number of bytes of complete lines.

    Raises:
        MissionError: a line before the last one is damaged.
    """
    entries: list[dict[str, Any]] = []
    whole = 0
    lines = path.read_bytes().splitlines(keepends=True)
    for number, line in enumerate(lines, start=1):
        entry = _entry(line)
        if entry is None and number < len(lines):
            raise MissionError(
                f"{path}:{number} is damaged",
                hint="remove this line to fly its row again, or take another folder with --out",
            )
        if entry is not None:
            entries.append(entry)
            whole += len(line)
    return (entries[0], entries[1:], whole) if entries else (None, [], 0)


def _entry(line: bytes) -> dict[str, Any] | None:
    """The content of a complete line; None for a damaged one."""
    try:
        entry = json.loads(line)
    except ValueError:
        return None
    return entry if line.endswith(b"\n") and isinstance(entry, dict) else None


def _other_campaign(
    folder: Path, before: Mapping[str, str], header: Mapping[str, str]
) -> MissionError:
    names = ["code", *before, *(name for name in header if name not in before)]  # best first
    name = next(name for name in names if before.get(name) != header.get(name))
    return MissionError(
        f"{folder} holds another campaign: its {name} is {before.get(name, 'not there')}, "
        f"and is {header.get(name, 'not there')} now",
        hint="rows of the two cannot be in one table; take another folder with --out",
    )
