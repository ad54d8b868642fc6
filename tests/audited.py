"""What `companion audit --json` answers."""

from __future__ import annotations

import json
from pathlib import Path

from commands import Companion


def outcomes(companion: Companion, run: Path) -> tuple[int, dict[str, tuple[str, int | None]]]:
    """Exit code, and the outcome and position of each conjunct; the last one of a name."""
    ended = companion("audit", run, "--json")
    answer = json.loads(ended.out)
    assert answer["version"] == 1
    assert answer["satisfied"] is (ended.code == 0)
    return ended.code, {c["conjunct"]: (c["outcome"], c["position"]) for c in answer["conjuncts"]}
