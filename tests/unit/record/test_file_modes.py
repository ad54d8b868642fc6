"""What the commands write can be changed by nobody else, whatever the umask they start with."""

from __future__ import annotations

import stat
import subprocess
import sys
from pathlib import Path

import pytest

MISSION = Path(__file__).parents[3] / "missions" / "surveillance.yaml"
NO_VEHICLE = ("--connect", "udpin://127.0.0.1:0", "--timeout", "0.1", "--monitor", "off")
OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH
OTHERS = stat.S_IRWXG | stat.S_IRWXO


@pytest.mark.parametrize(
    ("umask", "forbidden"), [(0, OTHERS_WRITE), pytest.param(0o077, OTHERS, marks=pytest.mark.long)]
)
def test_a_run_folder_and_what_lies_in_it(tmp_path: Path, umask: int, forbidden: int) -> None:
    runs = tmp_path / "new" / "runs"
    run = [sys.executable, "-m", "companion", "run", str(MISSION), *NO_VEHICLE]
    command = [*run, "--log-dir", str(runs)]
    ended = subprocess.run(command, umask=umask, capture_output=True, timeout=600, check=False)
    assert ended.returncode == 4, ended.stderr
    made = [runs.parent, *runs.parent.rglob("*")]
    assert {"mission.yaml", "events.jsonl", "flight.tlog"} <= {path.name for path in made}
    assert [path for path in made if path.stat().st_mode & forbidden] == []
