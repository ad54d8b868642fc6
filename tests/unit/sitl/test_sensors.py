"""Sensor readings: their rates, their noise, and the standard atmosphere."""

from __future__ import annotations

import math
from itertools import pairwise
from statistics import fmean, stdev
from typing import NamedTuple

import pytest

from companion.geometry import GlobalOrigin
from sitl.flight.estimate import GpsQuality
from sitl.flight.physics import FlightState, Physics
from sitl.flight.sensors import (
    BarometerSample,
    GpsFix,
    ImuSample,
    SensorNoise,
    Sensors,
    pressure_altitude_m,
)

PLACE = GlobalOrigin(47.4, 8.5, 488.0)
TRUTH = Physics(origin=PLACE, start=(30.0, -20.0, -12.0)).state
GOOD = GpsQuality()
NOISE = SensorNoise()
SILENT = SensorNoise(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
DT = 0.004


class Readings(NamedTuple):
    gps: GpsFix
    imu: ImuSample
    barometer: BarometerSample


def at(time_s: float) -> FlightState:
    return TRUTH._replace(time_s=time_s)


def sample(
    seconds: float,
    *,
    noise: SensorNoise = NOISE,
    seed: int = 1,
    gps: GpsQuality = GOOD,
    fix_error: tuple[float, float] = (0.0, 0.0),
) -> list[Readings]:
    sensors = Sensors(PLACE, seed, at(0.0), noise)
    readings = []
    for i in range(1, round(seconds / DT) + 1):
        sensors.step(at(i * DT), gps, fix_error)
        readings.append(Readings(sensors.gps, sensors.imu, sensors.barometer))
    return readings


def test_each_sensor_has_its_rate() -> None:
    readings = sample(40.0)
    assert len({r.gps.time_s for r in readings}) == pytest.approx(8 * 40, abs=1)
    assert len({r.imu.time_s for r in readings}) == pytest.approx(50 * 40, abs=1)
    assert len({r.barometer.time_s for r in readings}) == pytest.approx(20 * 40, abs=1)


def test_without_noise_they_read_the_truth() -> None:
    last = sample(1.0, noise=SILENT)[-1]
    assert (last.imu.specific_force, last.imu.rates) == (TRUTH.specific_force, TRUTH.rates)
    latitude_deg, longitude_deg, altitude_m = PLACE.to_global(TRUTH.position)
    assert (last.gps.latitude_deg, last.gps.longitude_deg) == (latitude_deg, longitude_deg)
    assert last.gps.altitude_m == pytest.approx(altitude_m)
    assert last.gps.velocity == TRUTH.velocity
    assert last.barometer.altitude_m == pytest.approx(500.0, abs=1e-6)


def test_the_barometer_weighs_the_standard_atmosphere() -> None:
    """ISO 2533: 954.61 hPa and 11.75 degrees at 500 m, 12 Pa less for each metre at the sea."""
    reading = sample(0.1, noise=SILENT)[-1].barometer
    assert reading.pressure_pa == pytest.approx(95461.0, abs=2.0)
    assert reading.temperature_degc == pytest.approx(11.75)
    assert pressure_altitude_m(101325.0 - 12.01) == pytest.approx(1.0, abs=0.01)


@pytest.mark.long
def test_noise_is_white_and_has_its_deviation() -> None:
    readings = sample(400.0)
    fixes = list({r.gps.time_s: r.gps for r in readings}.values())
    metres_per_degree = 111_320.0
    north = [metres_per_degree * fix.latitude_deg for fix in fixes]
    force = [r.specific_force[0] for r in {r.imu.time_s: r.imu for r in readings}.values()]
    rate = [r.rates[2] for r in {r.imu.time_s: r.imu for r in readings}.values()]
    pressure = [r.pressure_pa for r in {r.barometer.time_s: r.barometer for r in readings}.values()]
    for series, expected in (
        (north, NOISE.gps_horizontal_m),
        ([fix.altitude_m for fix in fixes], NOISE.gps_vertical_m),
        ([fix.velocity[1] for fix in fixes], NOISE.gps_speed_mps),
        (force, NOISE.acceleration_mps2),
        (rate, NOISE.rate_radps),
        (pressure, NOISE.pressure_pa),
    ):
        deviation = stdev(series)
        # Five deviations of the estimates.
        assert deviation == pytest.approx(expected, rel=5 / math.sqrt(2 * len(series)))
        mean = fmean(series)
        neighbours = fmean((a - mean) * (b - mean) for a, b in pairwise(series))
        assert abs(neighbours / deviation**2) < 5 / math.sqrt(len(series))
    # 1 Pa is 9 cm of air: PX4's barometer noise.
    assert stdev(r.barometer.altitude_m for r in readings) == pytest.approx(0.088, rel=0.1)


def test_the_receiver_shows_the_error_that_the_estimator_has() -> None:
    fix = sample(1.0, noise=SILENT, fix_error=(3.0, -4.0))[-1].gps
    true = PLACE.to_global(TRUTH.position)
    assert (fix.latitude_deg - true[0]) * 111_320 == pytest.approx(3.0, rel=0.01)
    assert fix.longitude_deg < true[1]
    assert fix.satellites == GOOD.satellites


def test_a_lost_gps_repeats_its_last_place_without_a_fix() -> None:
    sensors = Sensors(PLACE, 1, at(0.0))
    before = sensors.gps
    sensors.step(at(1.0), GpsQuality(is_lost=True), (0.0, 0.0))
    after = sensors.gps
    assert (before.is_3d, after.is_3d, after.satellites) == (True, False, 0)
    assert (after.latitude_deg, after.longitude_deg) == (before.latitude_deg, before.longitude_deg)


def test_the_same_seed_is_the_same_noise() -> None:
    assert sample(1.0, seed=4) == sample(1.0, seed=4)
    assert sample(1.0, seed=4)[-1].imu != sample(1.0, seed=5)[-1].imu


def test_who_looks_later_sees_a_sample_of_then() -> None:
    sensors = Sensors(PLACE, 1, at(0.0))
    first = sensors.imu
    sensors.step(at(7.003), GOOD, (0.0, 0.0))
    later = sensors.imu
    assert (first.time_s, later.time_s) == (0.0, 7.003)
    sensors.step(at(7.015), GOOD, (0.0, 0.0))
    assert sensors.imu is later
    sensors.step(at(7.02), GOOD, (0.0, 0.0))
    assert sensors.imu.time_s == 7.02


@pytest.mark.parametrize(("tilt_rad", "ground_up_m"), [(0.0, 0.0), (0.3, 0.0), (0.3, 5.0)])
def test_a_range_finder_looks_along_the_vehicle_s_axis_at_what_is_below(
    tilt_rad: float, ground_up_m: float
) -> None:
    sensors = Sensors(PLACE, 1, at(0.0))
    attitude = (math.cos(tilt_rad / 2), math.sin(tilt_rad / 2), 0.0, 0.0)
    sensors.step(at(1.0)._replace(attitude=attitude), GOOD, (0.0, 0.0), ground_up_m)
    assert sensors.range_below_m == pytest.approx((12.0 - ground_up_m) / math.cos(tilt_rad))


def test_it_sees_nothing_where_it_looks_up() -> None:
    sensors = Sensors(PLACE, 1, at(0.0))
    sensors.step(at(1.0)._replace(attitude=(0.0, 1.0, 0.0, 0.0)), GOOD, (0.0, 0.0))
    assert sensors.range_below_m == math.inf
