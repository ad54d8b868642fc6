"""The journal of a flight as a file: journal.jsonl, a line for each entry, append-only.

A line has `t_s` (the flight's clock), `unix_s`, `kind` and the fields of the entry. A thread writes
and syncs as many entries at once as have come meanwhile; the flight never waits for the disk. After
a power failure, what was not synced may be missing or torn at the end; a reader ignores that.
"""

from __future__ import annotations

import json
import os
import time
from dataclasses import replace
from pathlib import Path
from queue import SimpleQueue
from threading import Thread

from companion.acting.journal import (
    CommandIntended,
    CommandSettled,
    EndingBegun,
    EnergyLearnt,
    FlightBegun,
    FlightCounts,
    JournalEntry,
    JournalledFlight,
    OperatorSettings,
    PhaseBegun,
    PhotoReported,
    PlaceFound,
    VehicleSeen,
    put_together,
)
from companion.errors import CompanionError
from companion.flight_events.values import Unfit, object_of
from companion.flight_events.writing import json_of
from companion.geofence import KeptFence
from companion.planning import task_changes as changes
from companion.record.events import JOURNAL_FILE
from companion.record.json_lines import is_object, whole_lines
from companion.vehicle.ports.cameras import IntendedShot

KINDS: dict[str, type[JournalEntry]] = {
    "flight begun": FlightBegun,
    "phase": PhaseBegun,
    "ending": EndingBegun,
    "vehicle": VehicleSeen,
    "command intended": CommandIntended,
    "command settled": CommandSettled,
    "shot intended": IntendedShot,
    "photo reported": PhotoReported,
    "counts": FlightCounts,
    "place found": PlaceFound,
    "fence kept": KeptFence,
    "energy": EnergyLearnt,
    "settings": OperatorSettings,
    "action begun": changes.ActionBegun,
    "action completed": changes.ActionCompleted,
    "action interrupted": changes.ActionInterrupted,
    "action barred": changes.ActionBarred,
    "skills put aside": changes.SkillsPutAside,
    "skills put back": changes.SkillsPutBack,
    "skill overdue": changes.SkillOverdue,
    "no skill overdue": changes.OverdueForgotten,
    "flight begun again": changes.FlightResumed,
    "position read": changes.PositionRead,
    "vehicle departed": changes.VehicleDeparted,
    "event": changes.EventValueTaken,
    "beliefs withdrawn": changes.BeliefsWithdrawn,
    "beliefs cut off": changes.BeliefsCutOff,
    "beliefs restored": changes.BeliefsRestored,
    "lines dropped": changes.LinesDropped,
    "dropped lines kept": changes.DroppedLinesKept,
    "clocks changed": changes.ClocksChanged,
}
"""What a line says of each kind of entry; it stays the same if a class gets another name."""
_WORDS = {kind: words for words, kind in KINDS.items()}

_Noted = tuple[float, JournalEntry]


class JournalFile:
    """Implements `acting.journal.Journal`; new, or continued where a flight was cut off.

    Args:
        folder: the folder of the run.

    Attributes:
        failure: why nothing can be written any more; None while it can.

    Raises:
        OSError: the file cannot be created.
    """

    def __init__(self, folder: Path) -> None:
        self.failure: str | None = None
        self._noted = self._kept = 0
        self._queue: SimpleQueue[_Noted | None] = SimpleQueue()
        path = folder / JOURNAL_FILE
        whole = sum(map(len, _whole_lines(path))) if path.exists() else 0
        self._file = path.open("r+b" if whole else "wb")
        self._file.truncate(whole)
        self._file.seek(whole)
        _sync_folder(folder)
        self._thread = Thread(target=self._write, name="journal", daemon=True)
        self._thread.start()

    def note(self, now_s: float, entry: JournalEntry) -> None:
        """Passes an entry to the thread."""
        self._noted += 1
        self._queue.put((now_s, entry))

    @property
    def is_kept(self) -> bool:
        """Whether all entries are on the disk, or can never be written."""
        return self._kept >= self._noted or self.failure is not None

    def close(self) -> None:
        """Writes the remaining entries."""
        self._queue.put(None)
        self._thread.join()
        self._file.close()

    def _write(self) -> None:
        while True:
            batch = [self._queue.get()]
            while not self._queue.empty():
                batch.append(self._queue.get())
            entries = [noted for noted in batch if noted is not None]
            if self.failure is None:
                self._append(entries)
            self._kept += len(entries)
            if None in batch:
                return

    def _append(self, entries: list[_Noted]) -> None:
        unix_s = round(time.time(), 3)
        try:
            self._file.write(b"".join(_line(unix_s, *noted) for noted in entries))
            self._file.flush()
            os.fsync(self._file.fileno())
        except OSError as error:
            self.failure = error.strerror or str(error)


def read_journal(folder: Path, now_unix_s: float) -> JournalledFlight | None:
    """The state of the flight in a run folder; None if there is nothing to resume.

    Args:
        folder: the folder of the run.
        now_unix_s: the wall clock; if it was set back since, no time has passed.

    Raises:
        CompanionError: the journal is damaged before its end.
        OSError: it cannot be read.
    """
    path = folder / JOURNAL_FILE
    entries: list[_Noted] = []
    unix_s = 0.0
    for number, line in enumerate(_whole_lines(path), start=1):
        try:
            data = json.loads(line)
            unix_s = float(data.pop("unix_s"))
            time_s, kind = float(data.pop("t_s")), KINDS[data.pop("kind")]
            entries.append((time_s, object_of(kind, data)))
        except (ValueError, KeyError, TypeError, AttributeError, Unfit) as error:
            raise CompanionError(f"{path}:{number}: this is not an entry of a journal") from error
    flight = put_together(entries)
    return flight and replace(flight, away_s=max(0.0, now_unix_s - unix_s))


def _line(unix_s: float, now_s: float, entry: JournalEntry) -> bytes:
    about = {"t_s": round(now_s, 3), "unix_s": unix_s, "kind": _WORDS[type(entry)]}
    return json.dumps(about | json_of(entry)).encode() + b"\n"


def _whole_lines(path: Path) -> list[bytes]:
    """The complete lines with their line ends, without a torn end of the file.

    Raises:
        CompanionError: a damaged line stands between complete ones.
    """
    lines, _ = whole_lines(path.read_bytes())
    whole = [is_object(line) for line in lines]
    count = whole.index(False) if False in whole else len(lines)
    if any(whole[count:]):
        raise CompanionError(f"{path}:{count + 1}: the journal is damaged here")
    return lines[:count]


def _sync_folder(folder: Path) -> None:
    """Syncs the folder, so that its entry for the file is on the disk too."""
    number = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)
