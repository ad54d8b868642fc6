"""What is reckoned with for the error of a position, and when that changes."""

from __future__ import annotations

import pytest

from companion.motion.position_error import MOST_M, AddedClearance, greatest_error_m


def test_an_exact_position_adds_nothing() -> None:
    added = AddedClearance(0.15)
    assert not added.follow(0.0) and not added.follow(0.05)
    assert added.metres == 0.0


def test_the_error_adds_to_the_deviation_as_the_root_of_squares() -> None:
    added = AddedClearance(0.4)
    assert added.follow(0.25)  # 0.75 and 0.4 are 0.85
    assert added.metres == pytest.approx(0.4)


def test_the_clearance_follows_in_steps_and_lags_behind() -> None:
    added = AddedClearance(0.15)
    assert added.follow(0.25)
    before = added.metres
    assert not any(added.follow(accuracy_m) for accuracy_m in (0.24, 0.26, 0.25, 0.27))
    assert added.metres == before
    assert added.follow(0.5) and added.metres > before
    assert added.follow(0.02) and added.metres == 0.0


def test_what_the_vehicle_is_seen_to_be_off_counts_where_that_is_more() -> None:
    added = AddedClearance(0.4)
    assert not added.follow(0.0, 0.45) and added.metres == 0.0
    exact = AddedClearance(0.15)
    assert not exact.follow(0.055, 0.2), "a tenth of a metre changes nothing"
    assert added.follow(0.0, 0.9) and added.metres == pytest.approx(0.5)
    assert added.follow(0.25, 0.9) and added.metres == pytest.approx(0.8)  # 0.75 and 0.9 are 1.17
    assert added.follow(0.0, 9.0) and added.metres == pytest.approx(MOST_M - 0.4)
    assert added.follow(0.0, 0.2) and added.metres == 0.0


def test_a_position_that_is_lost_asks_for_no_more_than_that() -> None:
    assert greatest_error_m(100.0) == MOST_M
