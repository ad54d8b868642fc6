"""A trajectory is slowed for a vehicle that is behind, and gently however fast it is."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.motion.time_scaling import (
    DAMPED_MPS,
    FOLLOWS_SHARE,
    WAITS_SHARE,
    along,
    behind_m,
    time_rate,
)

SPEEDS = st.floats(0.1, 12.0)
SHARES = st.floats(0.0, 1.0)


@given(SPEEDS)
def test_a_vehicle_that_keeps_up_slows_nothing_and_one_that_stands_is_waited_for(
    speed_mps: float,
) -> None:
    assert time_rate(FOLLOWS_SHARE, speed_mps, speed_mps) == 1.0
    assert time_rate(WAITS_SHARE, speed_mps, 0.0) == 0.0
    assert time_rate(WAITS_SHARE, speed_mps, -1.0) == 0.0


@given(SPEEDS, st.floats(0.0, 1.0))
def test_a_vehicle_that_flies_as_fast_as_its_setpoint_is_as_far_behind_at_any_speed(
    speed_mps: float, rate: float
) -> None:
    behind_share = WAITS_SHARE - rate * (WAITS_SHARE - FOLLOWS_SHARE)
    assert time_rate(behind_share, speed_mps, rate * speed_mps) == pytest.approx(rate, abs=1e-6)


@given(SPEEDS, SHARES, SHARES, st.floats(-2.0, 14.0))
def test_the_setpoints_speed_changes_gently_with_the_distance(
    speed_mps: float, one_share: float, other_share: float, vehicle_mps: float
) -> None:
    """A reaction takes 0.1 s; the loop is steady while its gain times that is below 1."""
    told = [speed_mps * time_rate(s, speed_mps, vehicle_mps) for s in (one_share, other_share)]
    gain_mps = DAMPED_MPS / (WAITS_SHARE - FOLLOWS_SHARE)
    assert abs(told[1] - told[0]) <= gain_mps * abs(other_share - one_share) + 1e-6


@given(st.tuples(*[st.floats(-5.0, 5.0)] * 3), st.tuples(*[st.floats(-5.0, 5.0)] * 3))
def test_only_what_is_ahead_does_not_count(
    away: tuple[float, float, float], velocity: tuple[float, float, float]
) -> None:
    gap_m, behind = math.hypot(*away), behind_m(away, velocity)
    if along(away, velocity) >= 0.0:
        assert behind == pytest.approx(gap_m, abs=1e-6)
    else:
        assert math.hypot(behind, along(away, velocity)) == pytest.approx(gap_m, abs=1e-6)
