"""What a run that was cut off has left in its folder, made ready to be gone on with.

A program that is killed has written all but what it held; a power failure takes more. Files that
were begun may be missing then, or empty, or filled with zeros, or torn at the end. What the mission
says is written again, and what is torn is taken away. Of the word the journal has all (journal.py),
so lines that it does not have are taken away, and what is left out here is told by it again.
"""

from __future__ import annotations

import os
from pathlib import Path

from companion.errors import MissionError
from companion.flight_events.event import FlightEvent
from companion.flight_events.plans import PlanMade, TaskRecalled
from companion.flight_events.reading import read_line
from companion.flight_events.word import ConjunctViolated, PositionLeft
from companion.mavlink.framing import frame_size
from companion.record.events import is_lost

CHUNK_BYTES = 1 << 20
_STAMP_BYTES = 8
_HEAD_BYTES = 3
"""Of a frame: enough to know its size."""


class ToldWord:
    """What of the word a run folder has already.

    Attributes:
        has_task: whether it has the task as it is flown.
        positions: how many.
        violations: conjuncts, and the positions that violated them.
    """

    def __init__(self) -> None:
        self.has_task = False
        self.positions = 0
        self.violations: set[tuple[str, int]] = set()

    def __contains__(self, event: object) -> bool:
        match event:
            case TaskRecalled():
                return self.has_task
            case PositionLeft(number=number):
                return number < self.positions
            case ConjunctViolated(conjunct=conjunct, position=position):
                return (conjunct, position) in self.violations
        return False

    def add(self, event: FlightEvent) -> None:
        """An event that is in the folder."""
        match event:
            case PlanMade() | TaskRecalled():
                self.has_task = True
            case PositionLeft(number=number):
                self.positions = max(self.positions, number + 1)
            case ConjunctViolated(conjunct=conjunct, position=position):
                self.violations.add((conjunct, position))


def cut_events(path: Path, positions: int) -> ToldWord:
    """Takes away a torn last line, and all from a position on that the journal does not have.

    Returns:
        what is left.
    """
    lines = path.read_bytes().splitlines(keepends=True) if path.exists() else []
    told, kept = ToldWord(), 0
    for line in lines:
        try:
            event = read_line(line).event
        except MissionError:
            break
        if isinstance(event, PositionLeft) and event.number >= positions:
            break
        told.add(event)
        kept += len(line)
    if lines:
        os.truncate(path, kept)
    return told


def cut_tlog(path: Path) -> None:
    """Takes away a torn last record: nobody reads what comes behind one."""
    if path.exists():
        os.truncate(path, _whole_bytes(path))


def _whole_bytes(path: Path) -> int:
    """How many bytes of a flight.tlog are whole records."""
    whole = 0
    with path.open("rb") as file:
        while data := file.read(CHUNK_BYTES):
            at = 0
            while at + _STAMP_BYTES + _HEAD_BYTES <= len(data):
                size = frame_size(data, at + _STAMP_BYTES)
                if size is None:
                    return whole + at
                if at + _STAMP_BYTES + size > len(data):
                    break
                at += _STAMP_BYTES + size
            if at == 0:
                break
            whole += at
            file.seek(whole)
    return whole


def write_if_lost(path: Path, text: str) -> None:
    """Writes a file again that the power failure has taken."""
    if is_lost(path):
        path.write_text(text, encoding="utf-8")
