"""Uploads of a stranger: each is accepted, or refused in words, within 10 s and 512 MiB.

Six hundred of them with the marker `faults`, a few in every run. All 6,000, in two hours of one
core:

    python tests/faults/hostile_checks.py mission 0 5000
    python tests/faults/hostile_checks.py formula 0 500
    python tests/faults/hostile_checks.py bounds 0 500

They run in a process of their own, which forks a child for each.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from random import Random

import pytest
from hostile import MISSION, hostile
from meadow import DATA

pytestmark = [pytest.mark.faults, pytest.mark.slow]

CHECKS = Path(__file__).parent / "hostile_checks.py"
BATCH = 10
SMALL_MIB = 280
"""Of memory, in place of what a check has."""
BATCHES = [("mission", first) for first in range(0, 450, BATCH)]
BATCHES += [(kind, first) for kind in ("formula", "bounds") for first in range(0, 75, BATCH)]


@pytest.mark.parametrize(
    ("kind", "first"),
    [
        pytest.param(*batch, marks=[] if batch == ("mission", 0) else [pytest.mark.long])
        for batch in BATCHES
    ],
)
def test_every_upload_is_answered(kind: str, first: int) -> None:
    command = [sys.executable, str(CHECKS), kind, str(first), str(first + BATCH)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("accepted") == 1


def test_mutants_are_many_and_the_same_each_time() -> None:
    made = [hostile("mission", seed) for seed in range(40)]
    assert made == [hostile("mission", seed) for seed in range(40)]
    assert len({each.files[MISSION] for each in made}) > 30
    assert len({hostile("formula", seed).files[MISSION] for seed in range(20)}) == 20


@pytest.mark.long
@pytest.mark.parametrize("limit", [f"{SMALL_MIB} MiB of memory", "6 s of work"])
def test_bounds_that_can_hardly_be_kept_are_refused_in_words(tmp_path: Path, limit: str) -> None:
    """Twenty sites on an open field, four of them bounded."""
    random = Random(3)
    sites = {
        f"P{number}": {"east_m": random.randint(-90, 90), "north_m": random.randint(-90, 90)}
        for number in range(20)
    }
    asked = DATA | {
        "limits": {
            "speed_mps": 5,
            "up_m": [1, 20],
            "fence": [[-100, -100], [-100, 100], [100, 100], [100, -100]],
        },
        "places": {
            name: place | {"up_m": 5}
            for name, place in {"Home": {"east_m": 0, "north_m": 0}, **sites}.items()
        },
        "sets": {"Place": ["Home", *sites]},
        "task": {
            "all": f"patrolling({', '.join(sites)})",
            **{f"often_{i}": f"revisit(P{i}) <= {150 + i} s" for i in (0, 3, 5, 7)},
        },
    }
    (tmp_path / MISSION).write_text(json.dumps(asked), encoding="utf-8")
    order = json.dumps([str(tmp_path), MISSION, [], False])
    child = "from companion.cli import check_child as child; "
    if "memory" in limit:
        child += f"child.MEMORY_BYTES = {SMALL_MIB} * child.MIB; "
    command = [sys.executable, "-P", "-c", child + "child.main()"]
    done = subprocess.run(command, input=order + "\n", capture_output=True, text=True, check=True)
    answer = json.loads(done.stdout.splitlines()[-1])
    assert not answer["ok"]
    assert f"more than {limit} to check it; given up at its " in json.dumps(answer)
