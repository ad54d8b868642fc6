"""Scaled real time: its speed, its sleeps, and a machine that stalls."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.clock import ScaledClock

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
