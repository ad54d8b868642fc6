"""`companion runs`: a line for each recorded run; old ones are removed, those cut off never."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from commands import Companion

from companion.flight_events.event import Stamped
from companion.flight_events.skills import PlaceReached
from companion.flight_events.sortie import RunEnded, RunFailed, TaskSatisfied
from companion.flight_events.writing import line_of
from companion.record.run_list import list_runs

GOOD = TaskSatisfied()
BAD = RunFailed("the pilot has control", 5)


def record(log_dir: Path, name: str, ending: RunEnded | None, torn: bytes = b"") -> Path:
    """A run folder of two events, or of one and half a line."""
    folder = log_dir / name
    folder.mkdir(parents=True)
    events = [Stamped(61.5, PlaceReached("A", action="move(Home, A)"))]
    events += [Stamped(75.0, ending)] if ending is not None else []
    lines = "".join(json.dumps(line_of(event)) + "\n" for event in events)
    (folder / "events.jsonl").write_bytes(lines.encode() + torn)
    return folder


@pytest.fixture
def log_dir(tmp_path: Path) -> Path:
    record(tmp_path, "2026-11-21T101500-surveillance", GOOD)
    record(tmp_path, "2026-11-22T101500-corridor", None, torn=b'{"t_s": 62.0, "ki')
    record(tmp_path, "2026-11-23T101500-delivery", BAD)
    (tmp_path / "uploads").mkdir()
    (tmp_path / "latest").write_text("2026-11-23T101500-delivery\n")
    return tmp_path


def test_each_has_a_line_with_its_end(companion: Companion, log_dir: Path) -> None:
    ended = companion("runs", "--log-dir", log_dir)
    good, cut_off, bad, total = ended.out.splitlines()
    assert ended.code == 0
    assert good.split() == (
        "2026-11-21T101500-surveillance 1:15 0.0 MB 0 task satisfied, landed".split()
    )
    assert cut_off.split()[:4] == "2026-11-22T101500-corridor 1:01 0.0 MB".split()
    assert cut_off.endswith("-  no end: cut off, or still flown")
    assert bad.endswith("5  the pilot has control")
    assert total.startswith("3 runs, 0 MB in ")


def test_a_flown_run_is_listed_as_it_ended(
    companion: Companion, surveillance_run: Path, tmp_path: Path
) -> None:
    shutil.copytree(surveillance_run, tmp_path / "2026-11-21T101500-surveillance")
    ended = companion("runs", "--log-dir", tmp_path)
    assert "0  task satisfied, landed" in ended.out
    assert "MB" in ended.out and " 0.0 MB" not in ended.out


def test_the_newest_is_printed_alone_for_other_commands(
    companion: Companion, log_dir: Path
) -> None:
    ended = companion("runs", "--log-dir", log_dir, "--newest")
    assert ended.out == f"{log_dir / '2026-11-23T101500-delivery'}\n"


def test_pruning_keeps_the_newest_and_those_cut_off(companion: Companion, log_dir: Path) -> None:
    ended = companion("runs", "--log-dir", log_dir, "--prune", "1", "--yes")
    assert ended.out == "removed    1 runs up to 2026-11-21T101500-surveillance, 0 MB\n"
    assert [run.folder.name for run in list_runs(log_dir)] == [
        "2026-11-22T101500-corridor",
        "2026-11-23T101500-delivery",
    ]
    assert (log_dir / "uploads").is_dir()
    again = companion("runs", "--log-dir", log_dir, "--prune", "1", "--yes")
    assert again.out == "1 runs have ended: nothing to remove\n"


def test_nothing_is_removed_without_a_yes(companion: Companion, log_dir: Path) -> None:
    ended = companion("runs", "--log-dir", log_dir, "--prune", "0")
    assert ended.code != 0
    assert len(list_runs(log_dir)) == 3


def test_without_runs_it_says_how_to_make_one(companion: Companion, tmp_path: Path) -> None:
    ended = companion("runs", "--log-dir", tmp_path / "none")
    assert ended.code == 1
    assert "companion sim surveillance makes one" in ended.err


def test_a_run_folder_that_cannot_be_made(companion: Companion, tmp_path: Path) -> None:
    """It is told before anything is flown, in words."""
    (tmp_path / "file").write_text("in the way")
    folder = tmp_path / "file" / "runs"
    ended = companion("sim", "surveillance", "--speed", "max", "--log-dir", folder)
    assert ended.code == 1
    assert f"the run folder {folder}" in ended.err and "Not a directory" in ended.err
    assert "--log-dir DIR makes run folders in another place" in ended.err
