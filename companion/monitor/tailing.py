"""Reads what was added to a run folder's growing files since the last look.

`events.jsonl` is read in complete lines, `flight.tlog` in complete records: eight bytes of time and
one MAVLink frame. An incomplete end waits for the next look, so a file that is being written, or
was cut off, is read as far as possible. A door: it opens the files of a run folder.
"""

from __future__ import annotations

from pathlib import Path

from companion.errors import MissionError
from companion.flight_events.event import Stamped
from companion.flight_events.reading import read_line
from companion.record.json_lines import whole_lines
from companion.record.tlog_records import whole_records

CHUNK_BYTES = 1 << 19
"""Most bytes of flight.tlog that are read at once: 15 s of a flight."""


class EventLines:
    """The lines of an events.jsonl."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._at = 0

    def news(self) -> list[Stamped]:
        """The events since the last call; invalid lines are left out."""
        lines, _ = whole_lines(_read(self._path, self._at, -1))
        self._at += sum(map(len, lines))
        return [event for event in map(_event, lines) if event is not None]


class TlogFrames:
    """The frames of a flight.tlog."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._at = 0
        self._is_damaged = False

    def news(self) -> tuple[list[tuple[float, list[bytes]]], bool]:
        """Frames since the last call, as (seconds since 1970, frames of that time), and whether
        more can be read at once.

        The newest time waits until a later one has begun, because some of its frames may be
        missing. Nothing is read after a damaged record.
        """
        if self._is_damaged:
            return [], False
        data = _read(self._path, self._at, CHUNK_BYTES)
        batches: list[tuple[float, list[bytes]]] = []
        newest, at, whole = None, 0, 0
        records, self._is_damaged = whole_records(data)
        for record in records:
            if record.stamp_us != newest:
                newest, whole = record.stamp_us, at
                batches.append((record.stamp_us / 1e6, []))
            batches[-1][1].append(record.frame)
            at += record.size
        self._at += whole
        is_more = len(data) == CHUNK_BYTES and whole > 0 and not self._is_damaged
        return batches[:-1], is_more


def _read(path: Path, at: int, size: int) -> bytes:
    """Bytes of a file from an offset on; empty while the file does not exist."""
    try:
        with path.open("rb") as file:
            file.seek(at)
            return file.read(size)
    except OSError:
        return b""


def _event(line: bytes) -> Stamped | None:
    """The event in a line; None if it is not as documented: `companion audit` says why."""
    try:
        return read_line(line)
    except MissionError:
        return None
