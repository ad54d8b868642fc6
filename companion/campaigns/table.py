"""The table of a campaign: DIR/table.csv, the same bytes however its rows were flown.

Lines that begin with # are the header: `# key: value`. Then come the names of the columns and the
rows, in the order of their index. The table contains no time, no machine and no path.
"""

from __future__ import annotations

import csv
import io
import os
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from companion.campaigns.outcomes import FlownRow, Margins
from companion.campaigns.row_file import NotWritten
from companion.errors import MissionError

NAME = "table.csv"
MARK = "# "
QUOTE = '"'
QUOTED = frozenset(f"#,{QUOTE}\r\n")
"""Characters that end a cell or begin a comment, unless they are in quotes."""
FIRST = ("index", "generation", "seed")
MEASURED = (
    "outcome",
    "conjunct",
    "exit_code",
    "score",
    *(field.name for field in fields(Margins)),
    "replans",
    "duration_s",
    "phase",
    "place",
    "east_m",
    "north_m",
    "reason",
)


@dataclass(frozen=True, slots=True)
class Table:
    """A table as it was read.

    Attributes:
        header: by key.
        rows: the cells of each row as texts, by column.
    """

    header: Mapping[str, str]
    rows: tuple[Mapping[str, str], ...]


def table_text(header: Mapping[str, str], paths: Sequence[str], flown: Iterable[FlownRow]) -> str:
    """The table of some rows.

    Args:
        header: all that the rows depend on.
        paths: the paths of the factors, one column each.
        flown: in any order.
    """
    heads = [f"{MARK}{line}" for line in header_lines(header)]
    cells: list[Sequence[object]] = [[*FIRST, *paths, *MEASURED]]
    cells += (_values(each, paths) for each in sorted(flown, key=lambda each: each.row.index))
    rows = (",".join(map(_cell, row)) for row in cells)
    return "".join(f"{line}\n" for line in (*heads, *rows))


def header_lines(header: Mapping[str, str]) -> list[str]:
    r"""The header of a table, one line per key.

    >>> header_lines({"vary arming": "two\nlines (50%)"})
    ['vary arming: two\\nlines (50%)']
    """
    whole = (f"{key}: {value}" for key, value in header.items())
    return [line.replace("\r", r"\r").replace("\n", r"\n") for line in whole]


def write_whole(path: Path, text: str) -> None:
    """Writes a file atomically, with its folder: a reader sees the old file or the new one.

    Raises:
        NotWritten: it cannot be written; the old file is unchanged.
    """
    partial = path.with_name(f"{path.name}.partial")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with partial.open("w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        partial.replace(path)
    except OSError as error:
        with suppress(OSError):
            partial.unlink(missing_ok=True)
        raise NotWritten(path, error) from error


def read_table(path: Path) -> Table:
    """Reads a table.

    Raises:
        MissionError: it cannot be read, or is no table.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")  # as spreadsheets write it
    except (OSError, UnicodeDecodeError) as error:
        raise MissionError(f"the table {path} cannot be read: {error}") from error
    lines = []
    while text.startswith(MARK):
        line, _, text = text.removeprefix(MARK).partition("\n")
        lines.append(line)
    header = header_of(lines)
    try:
        rows = tuple(csv.DictReader(io.StringIO(text)))
    except csv.Error as error:
        raise MissionError(f"the table {path} cannot be read: {error}") from error
    if "format" not in header or (rows and "outcome" not in rows[0]):
        raise MissionError(f"{path} is not the table of a campaign")
    return Table(header, rows)


def header_of(lines: Iterable[str]) -> dict[str, str]:
    """The header that some lines contain, by key."""
    parts = (line.partition(": ") for line in lines)
    return {key: value for key, _, value in parts}


def _values(flown: FlownRow, paths: Sequence[str]) -> list[object]:
    row = flown.row
    values: dict[str, object] = {
        **asdict(flown),
        **asdict(flown.margins),
        "outcome": flown.outcome.value,
        "score": flown.score,
    }
    measured = [values[name] for name in MEASURED]
    return [row.index, row.generation, row.seed, *(row.values.get(p) for p in paths), *measured]


def _cell(value: object) -> str:
    """A value as text from which the same value can be read.

    >>> _cell("upload #2"), _cell(2.5)
    ('"upload #2"', '2.5')
    """
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    text = repr(value) if isinstance(value, float) else str(value)
    return f'"{text.replace(QUOTE, 2 * QUOTE)}"' if set(text) & QUOTED else text
