"""Scaled real time: its speed, its sleeps, and a machine that stalls."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.clock import ScaledClock

ROOT = Path(__file__).parents[2]
MAX_JUMP_S = 0.1


class Wall:
    """A machine's clock that is set by hand."""

    def __init__(self, now_s: float) -> None:
        self.now_s = now_s

    def __call__(self) -> float:
        return self.now_s


@pytest.mark.parametrize("speed", [0.5, 1.0, 20.0])
def test_a_scaled_clock(speed: float, monkeypatch: pytest.MonkeyPatch) -> None:
    slept_s: list[float] = []
    monkeypatch.setattr("companion.clock.time.sleep", slept_s.append)
    wall = Wall(1000.0)
    clock = ScaledClock(speed, monotonic_s=wall)
    assert clock.now_s() == 0.0
    wall.now_s = 1002.0
    assert clock.now_s() == 2.0 * speed
    clock.sleep_until(3.0 * speed)
    clock.sleep_until(1.0 * speed)
    assert slept_s == pytest.approx([1.0, 0.0])


@given(st.lists(st.floats(0, MAX_JUMP_S)), st.floats(0.01, 100))
def test_without_stalls_it_is_scaled_wall_time(steps: list[float], speed: float) -> None:
    wall, now_s = Wall(50.0), 0.0
    clock = ScaledClock(speed, MAX_JUMP_S, wall)
    for step in steps:
        wall.now_s += step
        now_s = clock.now_s()
    assert now_s == pytest.approx((wall.now_s - 50.0) * speed, abs=1e-9 * speed)


def test_a_stalled_machine_slows_it_down() -> None:
    wall = Wall(0.0)
    clock = ScaledClock(2.0, MAX_JUMP_S, wall)
    wall.now_s = 10.0
    assert clock.now_s() == pytest.approx(2.0 * MAX_JUMP_S)
    wall.now_s = 10.05
    assert clock.now_s() == pytest.approx(2.0 * (MAX_JUMP_S + 0.05))


STAMPS = {
    "companion/api/results.py": "the same as run_folders.py, for programs",
    "companion/flights/cut_off_runs.py": "how long a companion was away",
    "companion/flights/run_folders.py": "the name of a run folder, and the time of its record",
    "companion/mavlink/key_file.py": "what signatures begin with",
    "companion/record/clocks.py": "how other logs are laid beside a run",
    "companion/record/journal_file.py": "the same, written down",
}
"""Who reads the wall clock, which may be set at any time, and for what."""
WALL_CLOCKS = {"time", "time_ns", "now", "utcnow", "today", "localtime", "gmtime"}


NAMED = re.compile(rf"\b(time|datetime|date)\.({'|'.join(sorted(WALL_CLOCKS))})\b")


def reads_the_wall_clock(text: str) -> bool:
    """Whether something of `time` or `datetime` is called that tells the time of day."""
    if re.search(r"from (time|datetime) import", text):
        return True
    return bool(NAMED.search(text)) and any(  # a docstring may name it
        isinstance(node, ast.Attribute)
        and isinstance(node.value, ast.Name)
        and node.value.id in ("time", "datetime", "date")
        and node.attr in WALL_CLOCKS
        for node in ast.walk(ast.parse(text))
    )


def test_only_stamps_are_of_the_wall_clock() -> None:
    """So that no timer of a flight stops or fires when it is set."""
    readers = {
        str(path.relative_to(ROOT))
        for package in ("companion", "sitl")
        for path in (ROOT / package).rglob("*.py")
        if reads_the_wall_clock(path.read_text(encoding="utf-8"))
    }
    assert readers == set(STAMPS)


@pytest.mark.parametrize("factor", [0.25, 4.0])
def test_a_clock_goes_on_at_another_speed_from_what_it_shows(factor: float) -> None:
    wall = Wall(100.0)
    clock = ScaledClock(monotonic_s=wall)
    assert clock.zero_s == 100.0
    wall.now_s = 103.0
    clock.speed_up(factor)
    assert (clock.now_s(), clock.speed) == (3.0, factor)
    wall.now_s = 105.0
    assert clock.now_s() == 3.0 + 2.0 * factor
    assert clock.wall_s_until(3.0 + 3.0 * factor) == 1.0
    assert clock.zero_s is None
    clock.speed_up(1.0 / factor)
    assert clock.now_s() == 3.0 + 2.0 * factor
    assert clock.zero_s is None  # it showed less, or more, meanwhile
