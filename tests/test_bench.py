"""The measuring script runs and prints its rows; what it measures is nothing to assert.

docs/planning.md says `.venv/bin/python scripts/bench translating planning`; here each group is
measured with few repetitions, by what scripts/fly installs.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from first_installation import environment
from spot_authority import needs_spot

pytestmark = pytest.mark.slow

BENCH = Path(__file__).parents[1] / "scripts" / "bench"


@pytest.mark.parametrize(
    ("group", "count", "with_peer"),
    [
        pytest.param("translating", 28, set(), marks=pytest.mark.long),  # Spot comes with tests
        pytest.param(
            "planning",
            50,
            {
                "bounds in time, 8 sites, 3 bounds of 0.5 to 0.9 tours that may be dropped: "
                "which to drop in flight",
                "plan at the start, median",
                "replan en route, target found, median",
                "replan at r1, refused, median",
            },
            marks=pytest.mark.long,  # what it calls is tested by itself
        ),
        pytest.param(
            "flying",
            12,
            {
                "cost-to-go of a place",
                "cost-to-go repaired",
                "physics and control",
                "simulator and companion in lockstep",
                "event to setpoint of the new plan",
                "pack MAVLink",
                "parse MAVLink",
                "pack and sign MAVLink",
                "verify and parse MAVLink",
            },
            marks=pytest.mark.long,  # what it calls is flown everywhere, and its types are checked
        ),
        pytest.param(
            "campaigns",
            3,  # Dask comes with the tests alone
            {"campaign, 2 processes", "memory after 8 flights"},
            marks=pytest.mark.long,
        ),
        pytest.param("missions", 100, set(), marks=pytest.mark.long),  # flies them all
    ],
)
def test_every_row_is_measured(group: str, count: int, with_peer: set[str], tmp_path: Path) -> None:
    command = [sys.executable, str(BENCH), "--quick", "--json", group]
    done = subprocess.run(
        command,
        env=os.environ | environment(tmp_path),
        capture_output=True,
        text=True,
        timeout=900,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    rows = {row["name"]: row for row in json.loads(done.stdout)}
    assert len(rows) == count
    assert all(row["figure"] >= 0 and row["unit"] for row in rows.values())
    assert {name for name, row in rows.items() if row["ratio"]} == with_peer


@pytest.mark.long  # the group is measured above, without Spot
@needs_spot
def test_spot_is_the_peer_where_it_is_installed() -> None:
    command = [sys.executable, str(BENCH), "--quick", "--json", "translating"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=900, check=True)
    rows = json.loads(done.stdout)
    with_peer = [row for row in rows if row["ratio"]]
    assert len(with_peer) == 5 * 2 * 2 + 3 + 2
    assert all(row["peer"].startswith("Spot 2.") for row in with_peer)


def test_a_group_that_there_is_not_is_named() -> None:
    command = [sys.executable, str(BENCH), "flyng"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=900, check=False)
    assert done.returncode == 2
    assert (
        "no group flyng; there are translating, planning, flying, campaigns, missions"
        in done.stderr
    )


@pytest.mark.parametrize(
    ("script", "module", "installs"), [("bench", "", "fly"), ("mutate", "pytest", "test")]
)
def test_another_python_is_answered_in_a_line(script: str, module: str, installs: str) -> None:
    """One that has none of our libraries."""
    command = [sys.executable, "-S", str(BENCH.with_name(script))]
    own = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(command, env=own, capture_output=True, text=True, check=False)
    assert done.returncode == 1 and done.stdout == ""
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"scripts/{script}: this Python has no {module}")
    advice = f"run .venv/bin/python scripts/{script}, for which scripts/{installs} installs all"
    assert line.endswith(advice)
