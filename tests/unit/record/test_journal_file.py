"""The journal: what was written is read, also when the power has failed at any byte."""

from __future__ import annotations

import os
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.acting.journal import (
    CommandIntended,
    CommandSettled,
    FlightBegun,
    JournalEntry,
    OperatorSettings,
    PhaseBegun,
    PhotoReported,
    VehicleSeen,
    put_together,
)
from companion.errors import CompanionError
from companion.flight_events.sortie import Phase
from companion.planning.task_changes import (
    ActionCompleted,
    BeliefsWithdrawn,
    EventValueTaken,
    TaskMoment,
)
from companion.record.events import JOURNAL_FILE
from companion.record.journal_file import KINDS, JournalFile, read_journal

BEGUN = FlightBegun("survey", "survey.yaml", "ab12", start_s=0.25)
ARMING = PhaseBegun(Phase.ARMING)
MOMENT = TaskMoment(positions=0, now_s=0.0)
ENTRIES: list[JournalEntry] = [
    BEGUN,
    ARMING,
    BeliefsWithdrawn(MOMENT, ("can_do", "trans_ok(A, B)"), None),
    EventValueTaken(MOMENT, "found", True),
    VehicleSeen((1.0, 2.0, -3.0), (0.1, 0.2, 0.3), 488.0, system=1),
    CommandIntended(1, "do", "MAV_CMD_USER_1"),
    CommandSettled(1),
    CommandIntended(2, "do", "MAV_CMD_USER_1"),
    ActionCompleted(TaskMoment(3, 7.25), "do", 7.5),
    CommandIntended(3, "do", "MAV_CMD_USER_1"),
    PhotoReported("do", 3, 1),
    OperatorSettings(2.0, -1.0),
]


def written(folder: Path, entries: list[JournalEntry]) -> Path:
    journal = JournalFile(folder)
    for number, entry in enumerate(entries):
        journal.note(float(number), entry)
    journal.close()
    assert journal.is_kept
    return folder / JOURNAL_FILE


def test_what_was_written_is_read(tmp_path: Path) -> None:
    written(tmp_path, ENTRIES)
    flight = read_journal(tmp_path, 0.0)
    assert flight == put_together((float(n), entry) for n, entry in enumerate(ENTRIES))
    assert flight is not None and flight.unsettled == (ENTRIES[9],)
    assert flight.positions == 3 and flight.photos == {("do", 3, 1)}
    assert flight.phase is flight.flown is Phase.ARMING and flight.armed_s == 1.0
    later = read_journal(tmp_path, time.time() + 60.0)
    assert later is not None and 60.0 <= later.away_s < 600.0


@pytest.mark.parametrize(
    ("boot_s", "away_s"), [(100.0, 42.0), (58.5, 0.5), (57.9, 7.0), (2.0, 7.0)]
)
def test_the_time_away_is_the_autopilots_unless_its_clock_has_begun_anew(
    boot_s: float, away_s: float
) -> None:
    """Its clock showed 50 when the flight's showed 2; the last entry is of 10, 58 by its clock."""
    seen = VehicleSeen((1.0, 2.0, -3.0), (0.1, 0.2, 0.3), 488.0, system=1, zero_s=-48.0)
    entries: list[tuple[float, JournalEntry]] = [(0.0, BEGUN), (2.0, seen), (10.0, ARMING)]
    flight = put_together(entries)
    assert flight is not None
    assert replace(flight, away_s=7.0).found_at(boot_s).away_s == pytest.approx(away_s)


def test_without_the_autopilots_clock_the_wall_clock_counts() -> None:
    flight = put_together([(0.0, BEGUN), (1.0, ARMING), (2.0, ENTRIES[4])])
    assert flight is not None and replace(flight, away_s=7.0).found_at(50.0).away_s == 7.0
    not_seen = put_together([(0.0, BEGUN), (1.0, ARMING)])
    assert not_seen is not None and replace(not_seen, away_s=7.0).found_at(50.0).away_s == 7.0


@given(st.integers(0, 2000), st.binary(max_size=30))
def test_a_torn_end_is_left_out_and_overwritten(
    tmp_path_factory: pytest.TempPathFactory, cut: int, torn: bytes
) -> None:
    """Power fails at any byte, and leaves whatever in the sectors after it."""
    folder = tmp_path_factory.mktemp("run")
    path = written(folder, ENTRIES)
    text = path.read_bytes()[:cut]
    lines = text.count(b"\n")
    path.write_bytes(text + torn.replace(b"\n", b"\0"))
    flight = read_journal(folder, 0.0)
    assert flight == put_together((float(n), e) for n, e in enumerate(ENTRIES[:lines]))
    written(folder, [BEGUN, ARMING])
    assert path.read_bytes().count(b"\n") == lines + 2
    assert read_journal(folder, 0.0) is not None


def test_a_journal_that_is_damaged_in_the_middle_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path, ENTRIES)
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join([*lines[:3], b"\0\0\0\n", *lines[4:]]))
    with pytest.raises(CompanionError, match=r"journal\.jsonl:4: the journal is damaged"):
        read_journal(tmp_path, 0.0)


def test_an_entry_that_is_none_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path, ENTRIES)
    path.write_bytes(path.read_bytes().replace(b'"phase"', b'"stage"', 1))
    with pytest.raises(CompanionError, match=r"journal\.jsonl:2: this is not an entry"):
        read_journal(tmp_path, 0.0)


def test_every_kind_of_entry_has_its_word() -> None:
    assert list(KINDS.values()) == list(dict.fromkeys(KINDS.values()))
    assert set(KINDS.values()) == set(get_args(JournalEntry))


@pytest.mark.parametrize("entries", [[BEGUN], [BEGUN, ARMING, PhaseBegun(Phase.ENDED)]])
def test_without_arming_or_after_its_end_there_is_nothing_to_go_on_with(
    tmp_path: Path, entries: list[JournalEntry]
) -> None:
    written(tmp_path, entries)
    assert read_journal(tmp_path, 0.0) is None


def test_nothing_is_kept_before_the_disk_has_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A command waits for its intention; the flight does not."""
    journal = JournalFile(tmp_path)
    may_sync, sync = threading.Event(), os.fsync
    monkeypatch.setattr(os, "fsync", lambda number: (may_sync.wait(), sync(number))[1])
    journal.note(0.0, BEGUN)
    assert not journal.is_kept
    may_sync.set()
    journal.close()
    assert journal.is_kept


def test_a_full_disk_stops_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    journal = JournalFile(tmp_path)

    def full(number: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    journal.note(0.0, BEGUN)
    journal.close()
    assert journal.is_kept and journal.failure == "No space left on device"
