"""Gusts against MIL-F-8785C at low altitude, and wind that changes in flight."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from physics_steps import driven, flown
from wire import Wire

from companion.geometry import GlobalOrigin, euler_from_quaternion
from sitl.flight.controllers import Cascade, TrajectorySetpoint
from sitl.flight.physics import Physics
from sitl.world.scenario import Scenario

SEA = GlobalOrigin(47.4, 8.5, 0.0)
HILL = GlobalOrigin(47.4, 8.5, 488.0)
"""High above the sea; what counts is the height above the ground."""
HEIGHT_M, WIND_MPS, SIGMA_MPS = 6.0, 15.0, 0.4
SAMPLE_S = 0.02
M_PER_FT = 0.3048

# MIL-F-8785C, below 1000 ft; h in feet.
_SHAPE = 0.177 + 0.000823 * HEIGHT_M / M_PER_FT
LENGTH_M = np.array((HEIGHT_M / _SHAPE**1.2, HEIGHT_M / _SHAPE**1.2, HEIGHT_M))
DEVIATION_MPS = SIGMA_MPS * np.array((_SHAPE**-0.4, _SHAPE**-0.4, 1.0))


@pytest.fixture(scope="module")
def gusts() -> NDArray[np.float64]:
    """Along the wind, across it and down, every 20 ms for 10 minutes, of a vehicle that hovers.

    Along the wind they decorrelate in 2.9 s, so their variance is known to about 10 %.
    """
    home = (0.0, 0.0, -HEIGHT_M)
    physics = Physics(
        origin=HILL, start=home, wind=(WIND_MPS, 0.0, 0.0), turbulence_mps=SIGMA_MPS, seed=2
    )
    # No sensor of the vehicle feels the air alone, so JSBSim is asked.
    axes = [physics._node(f"atmosphere/gust-{axis}-fps") for axis in ("north", "east", "down")]
    cascade, setpoint, rows = Cascade(), TrajectorySetpoint(home, (0.0, 0.0, 0.0)), []
    for _ in range(round(600 / SAMPLE_S)):
        flown(physics, cascade, setpoint, SAMPLE_S)
        rows.append([axis.get_double_value() * M_PER_FT for axis in axes])
    assert math.dist(physics.state.position, home) < 2.0
    return np.array(rows)


@pytest.mark.long
def test_gusts_have_the_deviations_of_the_standard(gusts: NDArray[np.float64]) -> None:
    assert gusts.std(axis=0) == pytest.approx(DEVIATION_MPS.tolist(), rel=0.1)
    assert np.abs(gusts.mean(axis=0)).max() < 0.25 * SIGMA_MPS


@pytest.mark.long
@pytest.mark.parametrize("lag_s", [0.1, 0.2, 0.4, 0.8])
def test_gusts_have_the_spectra_of_dryden(gusts: NDArray[np.float64], lag_s: float) -> None:
    """The spectra's transforms: e^-x along, e^-x (1 - x/2) across and down, x = V lag / L."""
    lag = round(lag_s / (SAMPLE_S))
    found = (gusts[lag:] * gusts[:-lag]).mean(axis=0) / (gusts**2).mean(axis=0)
    x = WIND_MPS * lag_s / LENGTH_M
    expected = np.exp(-x) * (1 - np.array((0.0, 0.5, 0.5)) * x)
    assert found == pytest.approx(expected.tolist(), abs=0.06)


@pytest.mark.long
def test_gusts_fall_off_with_the_square_of_frequency(gusts: NDArray[np.float64]) -> None:
    """Beyond the corner at V / L each of Dryden's spectra falls by 20 dB a decade."""
    power = np.abs(np.fft.rfft(gusts * np.hanning(len(gusts))[:, None], axis=0)) ** 2
    hertz = np.fft.rfftfreq(len(gusts), SAMPLE_S)

    def band(low: float, high: float) -> NDArray[np.float64]:
        return np.asarray(power[(hertz >= low) & (hertz < high)].mean(axis=0))

    decibels = 10 * np.log10(band(1.9, 2.1) / band(3.8, 4.2))  # an octave
    assert decibels == pytest.approx([6.02] * 3, abs=1.0)


def test_no_wind_no_gusts() -> None:
    home = (0.0, 0.0, -HEIGHT_M)
    physics = Physics(origin=SEA, start=home, turbulence_mps=1.0, seed=2)
    cascade, setpoint = Cascade(), TrajectorySetpoint(home, (0.0, 0.0, 0.0))
    flown(physics, cascade, setpoint, 4.0)
    assert math.dist(physics.state.position, home) < 0.05


def begins(seed: int) -> tuple[float, ...]:
    """Where a vehicle is after half a second of gusts."""
    physics = Physics(
        origin=SEA, start=(0.0, 0.0, -5.0), wind=(3.0, 0.0, 0.0), turbulence_mps=1.0, seed=seed
    )
    for _ in range(125):
        driven(physics, (0.5, 0.5, 0.5, 0.5))
    return physics.state.position


def test_every_seed_has_its_own_gusts() -> None:
    limit = 2**31
    large = [limit - 3, limit - 2, limit - 1, limit, 2 * limit, 2 * limit + 1, 2**63, 10**40]
    seeds = [0, 1, 2, *large, -1, -2, -limit]
    found = [begins(seed) for seed in seeds]
    assert len(set(found)) == len(seeds)
    assert [begins(seed) for seed in seeds] == found


def test_a_hovering_vehicle_takes_a_step_of_wind() -> None:
    """It gives way less than wind and gains allow, comes back, and leans as the drag asks."""
    home = (0.0, 0.0, -10.0)
    physics, cascade = Physics(origin=SEA, start=home), Cascade()
    setpoint = TrajectorySetpoint(home, (0.0, 0.0, 0.0))
    flown(physics, cascade, setpoint, 6.0)
    physics.set_wind((0.0, 8.0, 0.0))
    track = flown(physics, cascade, setpoint, 12.0)
    drag_n = 4.75e-5 * 2136 * 8.0 + 0.5 * 1.225 * 0.016 * 8.0**2
    moved = [state.position[1] for state in track]
    # Without integrals the position loop would give way by acceleration / (P_velocity P_position).
    assert 0.02 < max(moved) < drag_n / 1.5 / (4.0 * 1.6)
    assert math.dist(track[-1].position, home) < 0.02
    roll_rad = euler_from_quaternion(track[-1].attitude)[0]
    assert math.tan(-roll_rad) == pytest.approx(drag_n / (1.5 * 9.808), rel=0.02)


@pytest.mark.parametrize("wind_mps", [pytest.param(4.0, marks=pytest.mark.long), 6.0])
def test_who_leans_into_the_wind_lands_on_its_feet(wind_mps: float) -> None:
    """PX4's heavy quadrotor leans by 22 and 31 degrees; with idle motors it would tip over."""
    wire = Wire(Scenario(airframe="px4_sih", wind=(wind_mps, 0.0, 0.0)))
    wire.fly_offboard(0.0, 0.0, -4.0)
    wire.set_mode("AUTO.LAND")
    touched_m = [wire.simulation.flight.position[0]]

    def is_down() -> bool:
        flight = wire.simulation.flight
        if not flight.is_on_ground:
            touched_m[0] = flight.position[0]
        return not wire.simulation.is_armed

    wire.run_until(is_down, 20.0)
    flight = wire.simulation.flight
    assert not wire.simulation.collisions and max(map(abs, flight.euler[:2])) < 0.05
    assert abs(flight.position[0] - touched_m[0]) < 1.0
