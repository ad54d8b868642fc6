"""When a position counts as being lost: bad and worse, not merely bad."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.vehicle.position_watch import (
    GROWTH,
    STEADY_S,
    WITHIN_S,
    WORST_M,
    PositionWatch,
)

ACCURACIES = st.floats(0.0, 20.0)
STEPS = st.floats(0.05, 10.0)
"""Between two reports."""


def drifting(reports: list[tuple[float, float]]) -> list[bool]:
    """What is said after each report: time and accuracy."""
    watch, said = PositionWatch(), []
    for now_s, accuracy_m in reports:
        watch.take(now_s, accuracy_m)
        said.append(watch.is_drifting)
    return said


def each_second(*accuracies_m: float) -> list[bool]:
    return drifting(list(enumerate(accuracies_m)))


def without_fixes(second: float, good_m: float, velocity_mps: float) -> float:
    """Accuracy so long after the last fix: the velocity's error is integrated."""
    return math.hypot(good_m, velocity_mps * second)


def test_where_nothing_is_told_nothing_drifts() -> None:
    assert PositionWatch().is_drifting is False


@given(ACCURACIES, st.lists(st.tuples(STEPS, st.floats(1.0, 0.999 * GROWTH)), max_size=30))
def test_a_receiver_may_be_as_bad_as_it_likes(
    best_m: float, told: list[tuple[float, float]]
) -> None:
    """As long as it stays as it is."""
    now_s, reports = 0.0, []
    for step_s, factor in told:
        now_s += step_s
        reports.append((now_s, factor * best_m * 0.999))
    assert not any(drifting([(0.0, best_m), *reports]))


@given(st.lists(ACCURACIES, max_size=20))
def test_what_gets_better_does_not_drift(told: list[float]) -> None:
    assert not any(each_second(*sorted(told, reverse=True)))


@given(st.lists(st.floats(0.0, WORST_M), max_size=20))
def test_while_clearances_follow_it_may_get_worse(told: list[float]) -> None:
    assert not any(each_second(*told))


@pytest.mark.parametrize("good_m", [0.05, 0.25, 0.3])
@pytest.mark.parametrize("velocity_mps", [0.3, 0.6])
def test_without_fixes_it_is_told_by_the_first_report_beyond_the_bound(
    good_m: float, velocity_mps: float
) -> None:
    """And until PX4's failsafe, which comes at 5 m or after 5 s."""
    told = [without_fixes(second, good_m, velocity_mps) for second in range(10)]
    said = drifting([*((s - 60.0, good_m) for s in range(60)), *enumerate(told)])[60:]
    assert said == [accuracy_m > WORST_M for accuracy_m in told] and any(said)


def test_limits_are_met_exactly() -> None:
    at, beyond = 0.5, math.nextafter(0.5, 1.0)
    assert WORST_M == at
    assert each_second(0.25, at) == [False, False]
    assert each_second(0.25, beyond) == [False, True]
    assert each_second(1.0, 1.5) == [False, False]
    assert each_second(1.0, math.nextafter(1.5, 2.0)) == [False, True]


def test_a_change_that_takes_longer_is_none() -> None:
    """What was told just `WITHIN_S` ago still counts, and what was told before does not."""
    assert drifting([(0.0, 1.0), (1.0, 1.4), (WITHIN_S, 2.0)])[-1] is True
    assert drifting([(0.0, 1.0), (1.0, 1.4), (2.0, 1.9), (WITHIN_S + 1.0, 2.0)])[-2:] == [
        True,
        False,
    ]


def test_it_lasts_until_the_reports_have_been_steady() -> None:
    said = each_second(0.3, 0.9, *[0.3] * 6)
    assert said == [False, True, True, True, False, False, False, False]
    assert drifting([(0.0, 0.3), (1.0, 0.9), (1.0 + STEADY_S - 0.01, 0.3)])[-1] is True


def test_after_a_silence_the_last_report_before_counts() -> None:
    assert drifting([(0.0, 0.3), (1.0, 0.3), (100.0, 0.9)])[-1] is True
    assert drifting([(0.0, 0.3), (1.0, 0.3), (100.0, 0.9), (110.0, 0.9)])[-1] is False


@given(st.lists(st.tuples(STEPS, ACCURACIES), max_size=40))
def test_it_begins_only_by_a_report_that_is_bad_and_worse(told: list[tuple[float, float]]) -> None:
    now_s, reports = 0.0, []
    for step_s, accuracy_m in told:
        now_s += step_s
        reports.append((now_s, accuracy_m))
    said = drifting(reports)
    for i, (before, now) in enumerate(pairwise([False, *said])):
        if now and not before:
            assert reports[i][1] > WORST_M
            assert reports[i][1] > GROWTH * min(accuracy_m for _, accuracy_m in reports[:i])
