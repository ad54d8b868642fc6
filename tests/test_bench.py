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
    assert len(rows) == 72
    assert all(row["figure"] > 0 and row["unit"] for row in rows.values())
    groups = ("dac", "eh", "sb", "mission", "mission-combo")
    assert {name for name, row in rows.items() if row["ratio"]} == {
        *(f"{group}, {kind}" for group in groups for kind in ("generalized", "state-based")),
        "one automaton, 3 sites",
        "one automaton, 5 sites",
        "plan at the start, median",
        "replan en route, target found, median",
        "replan at r1, refused, median",
        "field of the way to a place",
        "physics and control",
        "pack MAVLink",
        "parse MAVLink",
    }
