"""Reads what was added to a run folder's growing files since they were looked at last.

`events.jsonl` is read by whole lines, `flight.tlog` by whole records: eight bytes of time and one
MAVLink frame. What is not whole yet waits for the next look, so a file that is being written, or
was cut off in the middle, is read as far as it goes. A door: it opens the files of a run folder.
"""

from __future__ import annotations

import struct
from pathlib import Path

from companion.errors import MissionError
from companion.flight_events.event import Stamped
from companion.flight_events.reading import read_line
from companion.mavlink.framing import frame_size

CHUNK_BYTES = 1 << 19
"""At most so much of flight.tlog is read at once: 15 s of a flight."""
_STAMP = struct.Struct(">Q")  # microseconds since 1970


class EventLines:
    """The lines of an events.jsonl."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._at = 0

    def news(self) -> list[Stamped]:
        """The events since the last call; a line that is none is left out."""
        whole, newline, _ = _read(self._path, self._at, -1).rpartition(b"\n")
        self._at += len(whole) + len(newline)
        return [event for event in map(_event, whole.splitlines()) if event is not None]


class TlogFrames:
    """The frames of a flight.tlog."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._at = 0
        self._is_damaged = False

    def news(self) -> tuple[list[tuple[float, list[bytes]]], bool]:
        """Frames since the last call, as (seconds since 1970, those of one time), and whether more
        can be read at once.

        The newest time waits until a later one has begun: not all of its frames may be there yet.
        Nothing is read behind a damaged record.
        """
        if self._is_damaged:
            return [], False
        data = _read(self._path, self._at, CHUNK_BYTES)
        batches: list[tuple[float, list[bytes]]] = []
        newest, at, whole = None, 0, 0
        while at + 11 <= len(data):
            size = frame_size(data, at + 8)
            if size is None:
                self._is_damaged = True
                break
            if at + 8 + size > len(data):
                break
            (stamp,) = _STAMP.unpack_from(data, at)
            if stamp != newest:
                newest, whole = stamp, at
                batches.append((stamp / 1e6, []))
            batches[-1][1].append(data[at + 8 : at + 8 + size])
            at += 8 + size
        self._at += whole
        is_more = len(data) == CHUNK_BYTES and whole > 0 and not self._is_damaged
        return batches[:-1], is_more


def _read(path: Path, at: int, size: int) -> bytes:
    """Bytes of a file from a place on; none if it is not there (yet)."""
    try:
        with path.open("rb") as file:
            file.seek(at)
            return file.read(size)
    except OSError:
        return b""


def _event(line: bytes) -> Stamped | None:
    """A line's event; None if it is not as documented: `companion audit` says why."""
    try:
        return read_line(line)
    except MissionError:
        return None
