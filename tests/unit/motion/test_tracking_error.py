"""How far a vehicle is off its way: across it, past its end, and for how long that counts."""

from __future__ import annotations

import math

import pytest

from companion.motion.tracking_error import PATH_S, PERIOD_S, TrackingError

TICK_S = 0.05
JUMP_M = 1.0


def flown(
    error: TrackingError, begin_s: float, seconds: float, across_m: float, behind_m: float = 0.0
) -> None:
    """Goes on along the north axis at 1 m/s."""
    for i in range(round(seconds / TICK_S)):
        now_s = begin_s + TICK_S * i
        error.follow(now_s, (now_s, 0.0), (now_s - behind_m, across_m))


def test_one_that_lags_behind_is_on_its_way() -> None:
    error = TrackingError(JUMP_M)
    flown(error, 10.0, PATH_S, 0.0)
    flown(error, 10.0 + PATH_S, 20.0, 0.0, behind_m=0.9 * PATH_S)
    assert error.off_m == pytest.approx(0.0)


def test_what_counts_is_across_the_way_and_round_its_ends() -> None:
    error = TrackingError(JUMP_M)
    flown(error, 0.0, 10.0, -0.4)
    assert error.off_m == pytest.approx(0.4)
    flown(error, 10.0, 10.0, 0.6, behind_m=1.0)
    assert error.off_m == pytest.approx(0.6)


def test_it_is_told_in_steps() -> None:
    error, told = TrackingError(JUMP_M), set[float]()
    for i in range(100):
        flown(error, 0.5 * i, 0.5, i / 100)
        told.add(error.off_m)
    assert sorted(told) == pytest.approx([0.0, 0.2, 0.4, 0.6, 0.8, 1.0])


def test_one_that_swings_past_its_end_is_off_by_all_of_that() -> None:
    error = TrackingError(JUMP_M)
    flown(error, 0.0, 10.0, 0.0)
    for i in range(400):
        now_s = 10.0 + TICK_S * i
        error.follow(now_s, (10.0, 0.0), (10.0 + 0.8 * math.sin(now_s), 0.0))
    assert error.off_m == pytest.approx(0.8)


def test_the_most_counts_for_a_while_and_the_next_most_after_it() -> None:
    error = TrackingError(JUMP_M)
    flown(error, 0.0, 1.0, 0.8)
    flown(error, 1.0, PERIOD_S - 1.0, 0.0)
    flown(error, PERIOD_S, 1.0, 0.4)
    flown(error, PERIOD_S + 1.0, PERIOD_S - 2.0, 0.0)
    assert error.off_m == pytest.approx(0.8)
    flown(error, 2 * PERIOD_S, 5.0, 0.0)
    assert error.off_m == pytest.approx(0.4)
    flown(error, 3 * PERIOD_S, 5.0, 0.0)
    assert error.off_m == pytest.approx(0.0)


def test_setpoints_that_jump_and_a_pause_make_no_way() -> None:
    """The way from the one to the other is flown by nobody."""
    error = TrackingError(JUMP_M)
    flown(error, 0.0, 1.0, 0.0)
    for i in range(20):
        error.follow(1.0 + TICK_S * i, (20.0, 5.0), (20.0, 5.0))
    assert error.off_m == pytest.approx(0.0)
    error.pause(2.0)
    for i in range(60):
        error.follow(2.0 + TICK_S * i, (20.5, 5.0), (20.0 + i / 120, 6.0 - i / 60))
    assert error.off_m == pytest.approx(0.0)
    error.follow(2.0 + PATH_S + 0.25, (20.5, 5.0), (20.1, 5.0))
    assert error.off_m == pytest.approx(0.4)
