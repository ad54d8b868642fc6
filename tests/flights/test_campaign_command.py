"""companion campaign as a program: stopped, killed, resumed, compared."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import time
from pathlib import Path

import pytest
from varied import MISSION, SCENARIO

from companion.campaigns.row_file import NAME
from companion.python_child import python_module

pytestmark = pytest.mark.long

RUNS = 12
WAITS_S = 600.0


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Path:
    file = tmp_path_factory.mktemp("world") / "varied.sim.yaml"
    file.write_text(SCENARIO)
    return file


def begun(scenario: Path, folder: Path, *more: object) -> subprocess.Popen[str]:
    options = ["--scenario", scenario, "--runs", RUNS, "--limit-s", 60, "--jobs", 2, *more]
    return subprocess.Popen(
        python_module("companion", "campaign", *map(str, (MISSION, "--out", folder, *options))),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def ended(process: subprocess.Popen[str]) -> tuple[int, str]:
    out, err = process.communicate(timeout=WAITS_S)
    return process.returncode, out + err


def wait_for_rows(folder: Path, count: int) -> None:
    end_s = time.monotonic() + WAITS_S
    while time.monotonic() < end_s:
        file = folder / NAME
        if file.exists() and len(file.read_bytes().splitlines()) > count:
            return
        time.sleep(0.05)
    raise AssertionError(f"not {count} rows in {WAITS_S:.0f} s")


@pytest.fixture(scope="module")
def whole(scenario: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a campaign that nothing has disturbed; to be read only."""
    folder = tmp_path_factory.mktemp("whole")
    code, told = ended(begun(scenario, folder))
    assert code == 0, told
    assert "table " in told and "report " in told
    return folder


def test_ctrl_c_keeps_what_is_done_and_says_how_to_go_on(
    whole: Path, scenario: Path, tmp_path: Path
) -> None:
    process = begun(scenario, tmp_path / "stopped")
    wait_for_rows(tmp_path / "stopped", 2)
    process.send_signal(signal.SIGINT)
    code, told = ended(process)
    assert code == 1
    assert "rows are kept" in told and f"--resume {tmp_path / 'stopped'}" in told
    assert not (tmp_path / "stopped" / "table.csv").exists()
    code, told = ended(begun(scenario, tmp_path / "stopped"))
    assert code == 0, told
    same = [(each / "table.csv").read_bytes() for each in (whole, tmp_path / "stopped")]
    assert same[0] == same[1]


def test_a_campaign_that_is_killed_leaves_no_process_and_goes_on(
    whole: Path, scenario: Path, tmp_path: Path
) -> None:
    process = begun(scenario, tmp_path / "killed")
    wait_for_rows(tmp_path / "killed", 3)
    workers = children_of(process.pid)
    process.kill()
    process.communicate(timeout=WAITS_S)
    end_s = time.monotonic() + WAITS_S
    while any(is_there(pid) for pid in workers) and time.monotonic() < end_s:
        time.sleep(0.1)
    assert workers and not any(is_there(pid) for pid in workers)
    options = ("--resume", tmp_path / "killed", "--against", whole / "table.csv")
    code, told = ended(begun(scenario, tmp_path / "killed", *options))
    assert code == 0, told
    assert "McNemar    p = 1: may be chance" in told
    same = [(each / "table.csv").read_bytes() for each in (whole, tmp_path / "killed")]
    assert same[0] == same[1]


def test_a_full_disk_is_told_and_costs_no_row_that_was_kept(
    whole: Path, scenario: Path, tmp_path: Path
) -> None:
    """No file of the process may grow any more, as on a full disk; then there is room again."""
    folder = tmp_path / "full"
    process = begun(scenario, folder)
    wait_for_rows(folder, 2)
    most = (folder / NAME).stat().st_size + 10
    resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (most, most))
    code, told = ended(process)
    kept = (folder / NAME).read_bytes().count(b"\n") - 1  # a header; a torn line has no end
    assert code == 1
    assert f"{folder / NAME} cannot be written: File too large\n    {kept} rows are kept" in told
    assert f"--resume {folder}" in told and not (folder / "table.csv").exists()
    code, told = ended(begun(scenario, folder))
    assert code == 0, told
    same = [(each / "table.csv").read_bytes() for each in (whole, folder)]
    assert same[0] == same[1]


def children_of(pid: int) -> list[int]:
    listed = Path(f"/proc/{pid}/task/{pid}/children").read_text()
    return [int(child) for child in listed.split()]


def is_there(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
