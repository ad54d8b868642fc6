"""How fast a vehicle may fly that has to stop within what it sees."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.motion.profile import Motion, SpeedLimits
from companion.motion.speed_in_sight import LEAST_MPS, REACTION_S, fastest_mps
from companion.vehicle_profile import VehicleProfile

QUAD = VehicleProfile()
NUMBERS = st.floats(0.5, 10.0)


def needed_m(speed_mps: float, vehicle: VehicleProfile) -> float:
    """How far a vehicle comes that reacts late and brakes, and what it keeps then."""
    limits = SpeedLimits(speed_mps, vehicle.braking_mps2, vehicle.jerk_mps3)
    return speed_mps * REACTION_S + limits.stop_m(Motion(speed_mps)) + vehicle.clearance_m


@given(st.floats(0.0, 100.0), NUMBERS, NUMBERS)
def test_it_stops_within_sight(sight_m: float, braking_mps2: float, jerk_mps3: float) -> None:
    vehicle = replace(QUAD, braking_mps2=braking_mps2, jerk_mps3=jerk_mps3)
    speed_mps = fastest_mps(sight_m, vehicle)
    assert speed_mps == LEAST_MPS or needed_m(speed_mps, vehicle) <= sight_m + 1e-9


@pytest.mark.parametrize("sight_m", [4.0, 8.0, 30.0])
def test_and_is_no_slower_than_it_must_be(sight_m: float) -> None:
    speed_mps = fastest_mps(sight_m, QUAD)
    assert needed_m(speed_mps, QUAD) == pytest.approx(sight_m)


@given(st.floats(0.0, 100.0), st.floats(0.0, 100.0))
def test_who_sees_farther_flies_no_slower(one_m: float, other_m: float) -> None:
    nearer, farther = sorted((one_m, other_m))
    assert fastest_mps(nearer, QUAD) <= fastest_mps(farther, QUAD)
