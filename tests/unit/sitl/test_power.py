"""The default battery profile against the simulated vehicle that it is the profile of."""

from __future__ import annotations

import math
from statistics import fmean

import pytest
from physics_steps import flown

from companion.battery_profile import BatteryProfile
from companion.geometry import GlobalOrigin, Ned, moved, times
from sitl.flight.battery import BatterySpec
from sitl.flight.controllers import Cascade, ControllerLimits, TrajectorySetpoint
from sitl.flight.physics import Physics

SEA = GlobalOrigin(47.4, 8.5, 0.0)
FLIGHT_S = 16.0  # the first half until it is steady


def mean_w(velocity: Ned, wind: Ned = (0.0, 0.0, 0.0), charge: float = 0.8) -> float:
    """The mean power of a steady flight."""
    physics = Physics(origin=SEA, start=(0.0, 0.0, -60.0), wind=wind, battery=BatterySpec(charge))

    def steady(time_s: float) -> TrajectorySetpoint:
        ahead = time_s**2 / 8 if time_s < 4 else time_s - 2  # 4 s of acceleration
        share = min(1.0, time_s / 4)
        return TrajectorySetpoint(moved((0.0, 0.0, -60.0), velocity, ahead), times(velocity, share))

    states = flown(physics, Cascade(ControllerLimits(speed_mps=12.0)), steady, FLIGHT_S)
    return fmean(state.voltage_v * state.current_a for state in states[len(states) // 2 :])


@pytest.mark.parametrize("charge", [0.95, 0.5, 0.25])
def test_a_hover_takes_the_same_power_at_any_charge(charge: float) -> None:
    assert mean_w((0.0, 0.0, 0.0), charge=charge) == pytest.approx(
        BatteryProfile().power_w(0.0), 0.01
    )


@pytest.mark.parametrize("speed_mps", [2.0, 5.0, 10.0])
def test_level_flight(speed_mps: float) -> None:
    assert mean_w((speed_mps, 0.0, 0.0)) == pytest.approx(BatteryProfile().power_w(speed_mps), 0.01)


@pytest.mark.parametrize("climb_mps", [-1.0, 1.0, 2.5])
def test_climb_and_descent(climb_mps: float) -> None:
    expected_w = BatteryProfile().power_w(0.0, climb_mps)
    assert mean_w((0.0, 0.0, -climb_mps)) == pytest.approx(expected_w, 0.015)


@pytest.mark.parametrize("heading_deg", [0.0, 90.0, 180.0])
def test_wind_counts_by_the_speed_through_the_air(heading_deg: float) -> None:
    velocity = (
        2 * math.cos(math.radians(heading_deg)),
        2 * math.sin(math.radians(heading_deg)),
        0.0,
    )
    airspeed_mps = math.hypot(velocity[0] + 5, velocity[1])
    expected_w = BatteryProfile().power_w(airspeed_mps)
    assert mean_w(velocity, wind=(-5.0, 0.0, 0.0)) == pytest.approx(expected_w, 0.01)
