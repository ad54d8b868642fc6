"""Rates with exact intervals, two versions on the same rows, and what matters."""

from __future__ import annotations

import pytest

from companion.campaigns.statistics import Rate, compare, rank_correlation


@pytest.mark.parametrize(
    ("count", "total", "low", "high"),
    [(0, 150, 0.0, 2.4), (0, 1000, 0.0, 0.37), (3, 150, 0.4, 5.7), (12, 150, 4.2, 13.6)],
)
def test_intervals_are_those_of_clopper_and_pearson(
    count: int, total: int, low: float, high: float
) -> None:
    rate = Rate.of(count, total)
    assert 100 * rate.low == pytest.approx(low, abs=0.06)
    assert 100 * rate.high == pytest.approx(high, abs=0.06)


def test_nothing_is_known_of_no_rows() -> None:
    assert (Rate.of(0, 0).low, Rate.of(0, 0).high, Rate.of(0, 0).share) == (0.0, 1.0, 0.0)


def test_only_rows_that_differ_tell_two_versions_apart() -> None:
    before = [(i, i < 3) for i in range(100)]
    now = [(i, i < 10) for i in range(90)]
    found = compare(before, now)
    assert found.worse == tuple(range(3, 10)) and found.better == ()
    assert found.p == pytest.approx(2 * 0.5**7)
    assert found.is_significant
    assert not compare(before, before).is_significant


def test_ranks_that_rise_together_correlate() -> None:
    assert rank_correlation([1, 2, 3, 4], [1, 4, 9, 16]) == pytest.approx(1.0)
    assert rank_correlation([1, 2, 3, 4], [4, 3, 2, 1]) == pytest.approx(-1.0)
    assert rank_correlation([1, 1, 1, 1], [1, 2, 3, 4]) == 0.0
