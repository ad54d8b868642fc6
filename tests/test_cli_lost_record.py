"""Runs of which a power failure has left some files: what is said of them, and what is shown."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from commands import Companion

from companion.api.figures import trail_of_run
from companion.record.run_list import list_runs

LOSSES: dict[str, Callable[[Path], object]] = {
    "is missing": lambda path: path.unlink(),
    "is empty": lambda path: path.write_bytes(b""),
    "is empty, but for zeros": lambda path: path.write_bytes(bytes(5000)),
    "has no whole line": lambda path: path.write_bytes(path.read_bytes()[:40]),
}
SEEN = "where the vehicle was is in flight.tlog: companion replay {0} shows it"


NOW = ("is missing", "has no whole line")


@pytest.fixture(
    params=[pytest.param(how, marks=[] if how in NOW else [pytest.mark.long]) for how in LOSSES]
)
def lost(
    request: pytest.FixtureRequest, surveillance_run: Path, tmp_path: Path
) -> tuple[Path, str]:
    """A run of which the first third is left in flight.tlog, and events.jsonl is lost; how."""
    run = shutil.copytree(surveillance_run, tmp_path / "runs" / "run")
    packets = (run / "flight.tlog").read_bytes()
    (run / "flight.tlog").write_bytes(packets[: len(packets) // 3])
    LOSSES[request.param](run / "events.jsonl")
    return run, request.param.partition(",")[0]


def test_an_audit_says_what_is_lost_and_what_is_left(
    companion: Companion, lost: tuple[Path, str]
) -> None:
    run, how = lost
    ended = companion("audit", run)
    assert ended.code == 2
    assert f"events.jsonl {how}, so the run cannot be audited" in ended.err
    assert SEEN.format(run) in ended.err
    assert "what was planned is in plan-0.json to plan-2.json\n" in ended.err
    assert "no run folder" not in ended.err and "nothing was flown" not in ended.err


def test_what_is_left_is_shown(companion: Companion, lost: tuple[Path, str]) -> None:
    run, how = lost
    ((title, positions),) = trail_of_run(run).parts
    assert title == "before any plan that is recorded" and len(positions) > 100
    ended = companion("replay", run, "--mcap", run.parent / "run.mcap")
    assert ended.code == 0, ended.err
    assert f"notice     {run}/events.jsonl {how}" in ended.out
    (listed,) = list_runs(run.parent)
    assert listed.ending is None and listed.folder == run


def test_what_is_lost_besides_is_told_as_well(companion: Companion, lost: tuple[Path, str]) -> None:
    run, _ = lost
    (run / "scene.json").write_bytes(b"")
    (run / "journal.jsonl").write_bytes(b'{"t_s": 0.0}\n')
    said = companion("audit", run).err
    assert "MAVProxy and QGroundControl show it; scene.json is lost, too" in said
    assert "what of the task was done is in journal.jsonl: companion run --resume writes it" in said
    (run / "scene.json").unlink()
    (run / "flight.tlog").unlink()
    assert "flight.tlog" not in companion("audit", run).err
    replayed = companion("replay", run, "--port", 0)
    assert replayed.code == 2 and "so the run cannot be audited" in replayed.err
    figure = companion("figure", run)
    assert figure.code == 2 and "scene.json is missing, and nothing shows" in figure.err


def test_a_record_that_ends_before_a_plan_claims_nothing_of_the_flight(
    companion: Companion, surveillance_run: Path, tmp_path: Path
) -> None:
    lines = (surveillance_run / "events.jsonl").read_bytes().splitlines(keepends=True)
    (tmp_path / "events.jsonl").write_bytes(lines[2])
    ended = companion("audit", tmp_path)
    assert ended.code == 2
    assert "the run was cut off, and no plan is in what is left of it" in ended.err
