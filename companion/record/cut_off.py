"""Repairs the folder of a run that was cut off, so that the run can continue in it.

A killed program has written all but its buffers; a power failure takes more. New files may then be
missing, empty, filled with zeros, or torn at the end. Files from the mission are written again, and
torn ends are removed. The journal has the whole word (journal.py): lines that it does not have are
removed here, and it supplies what the files lack.
"""

from __future__ import annotations

import os
from pathlib import Path

from companion.errors import MissionError
from companion.flight_events.event import FlightEvent
from companion.flight_events.plans import PlanMade, TaskRecalled
from companion.flight_events.reading import read_line
from companion.flight_events.word import ConjunctViolated, PositionLeft
from companion.record.events import is_lost
from companion.record.json_lines import whole_lines
from companion.record.tlog_records import whole_records

CHUNK_BYTES = 1 << 20


class ToldWord:
    """What a run folder already has of the word.

    Attributes:
        has_task: whether it has the task as it is flown.
        positions: their number.
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
        """Adds an event of the folder."""
        match event:
            case PlanMade() | TaskRecalled():
                self.has_task = True
            case PositionLeft(number=number):
                self.positions = max(self.positions, number + 1)
            case ConjunctViolated(conjunct=conjunct, position=position):
                self.violations.add((conjunct, position))


def cut_events(path: Path, positions: int) -> ToldWord:
    """Removes a torn last line, and all positions from one on that the journal does not have.

    Returns:
        What remains.
    """
    lines, rest = whole_lines(path.read_bytes()) if path.exists() else ([], b"")
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
    if lines or rest:
        os.truncate(path, kept)
    return told


def cut_tlog(path: Path) -> None:
    """Removes a torn last record, behind which no program could read."""
    if path.exists():
        os.truncate(path, _whole_bytes(path))


def _whole_bytes(path: Path) -> int:
    """How many bytes of a flight.tlog are complete records."""
    whole = 0
    with path.open("rb") as file:
        while data := file.read(CHUNK_BYTES):
            records, is_damaged = whole_records(data)
            whole += sum(record.size for record in records)
            if is_damaged or not records:
                break
            file.seek(whole)
    return whole


def write_if_lost(path: Path, text: str) -> None:
    """Writes a file again if a power failure has taken it."""
    if is_lost(path):
        path.write_text(text, encoding="utf-8")
