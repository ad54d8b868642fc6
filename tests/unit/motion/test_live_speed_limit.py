"""The speed limit in force: how it follows its target, and what it does to a trajectory."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.geometry import distance
from companion.motion.live_speed_limit import LiveSpeedLimit
from companion.motion.profile import SpeedLimits
from companion.motion.routes import Route
from companion.motion.trajectory import Sample, Trajectory

LIMITS = SpeedLimits(2.0, 2.0, 8.0)
TICK_S = 0.05
ROUTE = Route(np.array([(0.0, 0.0, -2.0), (6.0, 0.0, -2.0), (6.0, 5.0, -2.0), (9.0, 9.0, -3.0)]))


def fly(limit: LiveSpeedLimit, orders: dict[int, float]) -> list[tuple[Sample, float]]:
    """The setpoints of a trajectory under a limit that is changed at some ticks."""
    trajectory, t_s, flown = Trajectory(ROUTE, limit.for_trajectory), 0.0, []
    for tick in range(4000):
        if tick in orders:
            limit.set_operator_limit(orders[tick])
        limit.advance(tick * TICK_S)
        sample, rate = limit.slowed(trajectory.sample(t_s))
        flown.append((sample, limit.now_mps))
        if sample.is_finished:
            return flown
        t_s += rate * TICK_S
    raise AssertionError("never finished")


def speeds(flown: list[tuple[Sample, float]]) -> list[float]:
    return [math.hypot(*sample.velocity) for sample, _ in flown]


def test_without_an_order_a_trajectory_is_flown_as_it_is() -> None:
    trajectory, t_s = Trajectory(ROUTE, LIMITS), 0.0
    for sample, _ in fly(LiveSpeedLimit(LIMITS), {}):
        assert sample == trajectory.sample(t_s)
        t_s += TICK_S


def test_the_target_changes_at_once_and_the_limit_in_force_at_the_acceleration() -> None:
    limit = LiveSpeedLimit(LIMITS)
    limit.advance(0.0)
    limit.set_operator_limit(0.5)
    assert (limit.target.speed_mps, limit.now_mps, limit.version) == (0.5, 2.0, 1)
    assert limit.for_trajectory.speed_mps == 2.0
    limit.advance(0.5)
    assert limit.now_mps == pytest.approx(1.0)
    limit.advance(1.0)
    assert limit.now_mps == 0.5
    assert limit.for_trajectory == limit.target
    limit.set_operator_limit(0.5)
    assert limit.version == 1


def test_a_slower_vehicle_has_less_drag_in_proportion_to_its_speed() -> None:
    """Its acceleration is another matter: none, at the limit."""
    limit = LiveSpeedLimit(LIMITS)
    limit.set_operator_limit(1.0)
    limit.advance(0.0)
    limit.advance(5.0)
    forward = (2.0, 0.0, 0.0)
    sample = Sample((0.0, 0.0, -2.0), forward, (0.0, 0.0, 0.0), False, against_drag=forward)
    slowed, rate = limit.slowed(sample)
    assert rate == 0.5 and slowed.fed_forward == (1.0, 0.0, 0.0)


def test_an_operator_cannot_allow_more_than_the_mission() -> None:
    limit = LiveSpeedLimit(LIMITS)
    limit.set_operator_limit(50.0)
    assert (limit.target, limit.version) == (LIMITS, 0)
    limit.set_operator_limit(1.0)
    limit.set_operator_limit(50.0)
    assert limit.target == LIMITS


def test_a_flight_under_way_slows_down_along_its_path() -> None:
    flown = fly(LiveSpeedLimit(LIMITS), {40: 0.5})
    fastest = speeds(flown)
    assert max(fastest) == pytest.approx(2.0)
    assert max(fastest[62:]) <= 0.5 * (1 + 1e-6)  # (2.0 - 0.5) / 2.0 s later
    assert flown[-1][0].position == (9.0, 9.0, -3.0)


@pytest.mark.slow
@given(
    st.dictionaries(
        st.integers(0, 400), st.sampled_from([0.1, 0.4, 0.8, 1.5, 2.0, 50.0]), max_size=6
    )
)
def test_whatever_is_ordered_no_setpoint_is_above_the_limit_or_jumps(
    orders: dict[int, float],
) -> None:
    """The gate holds a vehicle whose setpoint is above the limit in force."""
    flown = fly(LiveSpeedLimit(LIMITS), orders)
    assert all(math.hypot(*s.velocity) <= now * (1 + 1e-6) for s, now in flown)
    most_mps2 = 2 * LIMITS.acceleration_mps2  # that of the trajectory and that of the limit
    for (before, _), (after, _) in pairwise(flown):
        changed_mps = abs(math.hypot(*after.velocity) - math.hypot(*before.velocity))
        assert changed_mps <= most_mps2 * TICK_S + 1e-6
        assert distance(before.position, after.position) <= 2.0 * TICK_S + 1e-6
