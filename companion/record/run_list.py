"""The run folders below a folder: when each began, what it flew, and how it ended.

Only the end of each events.jsonl is read, so a thousand runs are listed quickly. A run without an
end was cut off, or still goes on. Files of other programs in the folder are ignored.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from companion.errors import Location, MissionError
from companion.flight_events.event import Stamped
from companion.flight_events.reading import read_line
from companion.flight_events.sortie import RunEnded
from companion.record.events import EVENTS_FILE, SCENE_FILE

LAST_BYTES = 65_536
"""How much of the end of events.jsonl is read; no final line is longer."""


@dataclass(frozen=True)
class RunSummary:
    """The summary of a run folder.

    Attributes:
        folder: the folder of the run; its name begins with the local time of the run's beginning.
        length_s: time of the last readable event; 0 if there is none.
        ending: how the run ended; None if it was cut off or still goes on.
        size_bytes: the size of all its files.
    """

    folder: Path
    length_s: float
    ending: RunEnded | None
    size_bytes: int


def list_runs(log_dir: Path) -> list[RunSummary]:
    """The runs in a folder, the oldest first; empty if the folder does not exist."""
    if not log_dir.is_dir():
        return []
    known = (EVENTS_FILE, SCENE_FILE)  # the events may be lost
    folders = (path for path in log_dir.iterdir() if any((path / f).is_file() for f in known))
    return [summary(folder) for folder in sorted(folders)]


def summary(folder: Path) -> RunSummary:
    """The summary of a run folder."""
    last = _last_event(folder / EVENTS_FILE)
    ending = last.event if last is not None and isinstance(last.event, RunEnded) else None
    size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
    return RunSummary(folder, last.time_s if last is not None else 0.0, ending, size)


def _last_event(path: Path) -> Stamped | None:
    """The last complete line that is an event; None if there is none."""
    if not path.is_file():
        return None
    with path.open("rb") as file:
        file.seek(max(0, path.stat().st_size - LAST_BYTES))
        lines = file.read().split(b"\n")
    for line in reversed(lines):
        try:
            return read_line(line, Location(str(path), 1, 1))
        except MissionError:
            continue
    return None
