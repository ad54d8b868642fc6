"""What the benches share: rows of the table, and measurement of times."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

ROOT = Path(__file__).resolve().parents[2]
MISSION = ROOT / "missions" / "surveillance.yaml"


@dataclass(frozen=True, slots=True)
class Row:
    """One figure, and the peer's in the same unit, if there is one."""

    name: str
    figure: float
    unit: str
    peer: str | None = None
    peer_figure: float | None = None

    @property
    def ratio(self) -> float | None:
        """Ours divided by the peer's."""
        return self.figure / self.peer_figure if self.peer_figure else None


def timed(call: Callable[[], object], runs: int) -> list[float]:
    """The milliseconds of each of several calls."""
    passed = []
    for _ in range(runs):
        start_s = perf_counter()
        call()
        passed.append(1000 * (perf_counter() - start_s))
    return passed
