"""The measuring script runs and prints its rows; what it measures is nothing to assert.

README.md says `.venv/bin/python scripts/bench translating planning`; here all groups are measured,
with few repetitions.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

BENCH = Path(__file__).parents[1] / "scripts" / "bench"


def test_every_row_is_measured() -> None:
    command = [sys.executable, str(BENCH), "--quick", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    rows = {row["name"]: row for row in json.loads(done.stdout)}
    assert len(rows) == 9
    assert all(row["figure"] > 0 and row["unit"] for row in rows.values())
    assert {name for name, row in rows.items() if row["ratio"]} == {
        "field of the way to a place",
        "physics and control",
        "pack MAVLink",
        "parse MAVLink",
    }
