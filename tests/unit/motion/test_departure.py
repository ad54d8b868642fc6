"""How a flight is given up at speed, of which the autopilot was not told in advance."""

from __future__ import annotations

import math

import numpy as np
import pytest

from companion.motion.departure import gentle
from companion.motion.profile import Motion, SpeedLimits
from companion.motion.routes import Route
from companion.motion.trajectory import Stop, Trajectory, motion_of
from companion.tick import TICK_S

STRAIGHT = Route(np.array([(0.0, 0.0, -3.0), (60.0, 0.0, -3.0)]))


@pytest.mark.parametrize("speed_mps", [2.0, 4.0, 8.0])
def test_a_stop_is_never_faster_than_the_flight_may_be(speed_mps: float) -> None:
    """Wherever in the acceleration it begins."""
    limits = SpeedLimits(speed_mps, 2.0, 8.0)
    trajectory = Trajectory(STRAIGHT, limits)
    for tick in range(1, round(speed_mps / 2.0 / TICK_S) + 10):
        now = trajectory.sample(tick * TICK_S)
        motion = motion_of(now.velocity, now.acceleration)
        stop = Stop(trajectory, tick * TICK_S, motion, gentle(limits, now))
        times_s = np.arange(0.0, stop.duration_s, TICK_S)
        fastest_mps = max(math.hypot(*stop.sample(t_s).velocity) for t_s in times_s)
        assert fastest_mps <= speed_mps * 1.0001


def test_where_the_speed_limit_is_far_the_jerk_is_half_of_the_greatest() -> None:
    limits = SpeedLimits(4.0, 2.0, 8.0)
    trajectory = Trajectory(STRAIGHT, limits)
    early, cruising = trajectory.sample(1.0), trajectory.sample(5.0)
    assert motion_of(cruising.velocity, cruising.acceleration) == Motion(4.0, 0.0)
    assert [gentle(limits, now).jerk_mps3 for now in (early, cruising)] == [4.0, 4.0]
