"""Uploads of a stranger: each is accepted, or refused in words, within 10 s and 512 MiB.

Five hundred of them with the marker `faults`, a few in every run. All 5,500 of the promise, in an
hour and a half of one core:

    python tests/faults/hostile_checks.py mission 0 5000
    python tests/faults/hostile_checks.py formula 0 500

They run in a process of their own, which forks a child for each.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from hostile import MISSION, hostile

pytestmark = [pytest.mark.faults, pytest.mark.slow]

CHECKS = Path(__file__).parent / "hostile_checks.py"
BATCH = 25
BATCHES = [("mission", first) for first in range(0, 450, BATCH)] + [("formula", 0), ("formula", 25)]


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
