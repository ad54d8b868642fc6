"""What has been added to a run folder's growing files since they were looked at last?

`events.jsonl` is read by whole lines, `flight.tlog` by whole records: eight bytes of time and one
MAVLink frame. What is not whole yet waits for the next look, so a file that is being written, or
was cut off in the middle, is read as far as it goes. A door: it opens the files of a run folder.
"""

from __future__ import annotations

import json
import math
import struct
from pathlib import Path
from typing import Any

from companion.mavlink.framing import frame_size

CHUNK_BYTES = 1 << 19
"""At most so much of flight.tlog is read at once: 15 s of a flight."""
_STAMP = struct.Struct(">Q")  # microseconds since 1970


class EventLines:
    """The lines of an events.jsonl."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._at = 0

    def news(self) -> list[dict[str, Any]]:
        """The lines since the last call; what is no JSON object is left out."""
        whole, newline, _ = _read(self._path, self._at, -1).rpartition(b"\n")
        self._at += len(whole) + len(newline)
        return [line for line in map(_json, whole.splitlines()) if line is not None]


class TlogFrames:
    """The frames of a flight.tlog."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._at = 0
        self._is_damaged = False

    def news(self) -> tuple[list[tuple[float, list[bytes]]], bool]:
        """Frames since the last call, as (seconds since 1970, those of one time), and: is there
        more that can be read at once?

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


def _json(text: bytes) -> dict[str, Any] | None:
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        return None
    is_event = (
        isinstance(found, dict)
        and isinstance(found.get("kind"), str)
        and isinstance(found.get("t_s"), int | float)
        and math.isfinite(found["t_s"])
    )
    return found if is_event else None
