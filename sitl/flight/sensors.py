"""GPS, inertial unit, barometer, and a downward range finder, each at its own rate.

In: the true state at each step, and the quality of GPS. Out: the newest sample of each sensor, held
until the next is due, as a driver's topic holds it. The samples are only for messages that show raw
sensors (HIGHRES_IMU, GPS_RAW_INT, SCALED_PRESSURE, DISTANCE_SENSOR); the estimate does not use
them. Inertial unit, barometer and the range finder, which is exact, are sampled only on demand.

Noise is white: that of PX4's simulated sensors (SensorGpsSim, SensorBaroSim, the IMU of its iris
model: a density times the root of the rate). The wandering part of GPS is the estimator's
`fix_error`, so that estimate and receiver agree. Left out: biases, temperature drift, vibration,
the magnetometer.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from companion.geometry import GlobalOrigin, Ned
from sitl.flight.estimate import GpsQuality
from sitl.flight.physics import FlightState

GPS_HZ, IMU_HZ, BAROMETER_HZ = 8.0, 50.0, 20.0
GPS_ACCURACY_M, GPS_LOST_ACCURACY_M = 0.9, 100.0  # SensorGpsSim's eph
EARLY_S = 1e-6  # sums of intervals are not exact

# International Standard Atmosphere up to 11 km: p = p0 (T / T0)^5.25588, T = T0 - 6.5 K/km.
SEA_PRESSURE_PA, SEA_TEMPERATURE_K, LAPSE_K_PER_M = 101325.0, 288.15, 0.0065
PRESSURE_EXPONENT = 5.25588
CELSIUS_ZERO_K = 273.15


@dataclass(frozen=True, slots=True)
class SensorNoise:
    """Standard deviations of one sample."""

    gps_horizontal_m: float = 0.2
    gps_vertical_m: float = 0.5
    gps_speed_mps: float = 0.06
    acceleration_mps2: float = 0.00186 * math.sqrt(IMU_HZ)
    rate_radps: float = 0.000187 * math.sqrt(IMU_HZ)
    pressure_pa: float = 1.0


@dataclass(frozen=True, slots=True)
class GpsFix:
    """A report of the GPS receiver.

    Attributes:
        time_s: the time of the sample.
        is_3d: whether the position is fixed; if not, it is the last one.
        latitude_deg: WGS 84.
        longitude_deg: WGS 84.
        altitude_m: above mean sea level.
        velocity: NED, m/s.
        satellites: used.
        horizontal_accuracy_m: as the receiver claims.
    """

    time_s: float
    is_3d: bool
    latitude_deg: float
    longitude_deg: float
    altitude_m: float
    velocity: Ned
    satellites: int
    horizontal_accuracy_m: float


@dataclass(frozen=True, slots=True)
class ImuSample:
    """Accelerometer (m/s^2) and gyroscope (rad/s), body."""

    time_s: float
    specific_force: tuple[float, float, float]
    rates: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class BarometerSample:
    """Static pressure, the height above sea level that it stands for, and the air temperature."""

    time_s: float
    pressure_pa: float
    altitude_m: float
    temperature_degc: float


Sample = TypeVar("Sample")


class HeldSample(Generic[Sample]):
    """The newest sample of a sensor, taken on demand when the next one is due.

    Args:
        rate_hz: how often a sample is due.
        state: the true state at the start, for the first sample.
        take: makes a sample of a true state.
    """

    def __init__(
        self, rate_hz: float, state: FlightState, take: Callable[[FlightState], Sample]
    ) -> None:
        self._rate_hz, self._take, self._sample = rate_hz, take, take(state)
        self._due_s = state.time_s + 1 / rate_hz

    def at(self, truth: FlightState) -> Sample:
        """The newest sample, given the present true state."""
        late_s = truth.time_s + EARLY_S - self._due_s
        if late_s >= 0:
            self._due_s += (math.floor(late_s * self._rate_hz) + 1) / self._rate_hz
            self._sample = self._take(truth)
        return self._sample


class Sensors:
    """The sensors of one vehicle.

    Args:
        origin: where local NED lies.
        seed: the seed of the noise; each sensor has its own stream.
        state: at the start; every sensor is sampled once.
        noise: the noise of each sensor.

    Attributes:
        gps: the receiver's newest report.
    """

    def __init__(
        self,
        origin: GlobalOrigin,
        seed: int,
        state: FlightState,
        noise: SensorNoise = SensorNoise(),
    ) -> None:
        self._origin, self._noise, self._truth = origin, noise, state
        self._ground_up_m = 0.0
        self._gps_gauss, self._imu_gauss, self._barometer_gauss = (
            random.Random(f"{sensor} {seed}").gauss for sensor in ("gps", "imu", "barometer")
        )
        self._imu = HeldSample(IMU_HZ, state, self._sample_imu)
        self._barometer = HeldSample(BAROMETER_HZ, state, self._sample_barometer)
        self._gps_s = state.time_s
        self.step(state, GpsQuality(), (0.0, 0.0))

    def step(
        self,
        truth: FlightState,
        gps: GpsQuality,
        fix_error: tuple[float, float],
        ground_up_m: float = 0.0,
    ) -> None:
        """Takes the true state, and makes a report of the receiver if it is due.

        Args:
            truth: the true state now.
            gps: the quality of GPS.
            fix_error: north and east, the slowly wandering part.
            ground_up_m: height above home of the ground, or a roof, below the vehicle.
        """
        self._truth, self._ground_up_m = truth, ground_up_m
        if truth.time_s + EARLY_S >= self._gps_s:
            self._gps_s += 1 / GPS_HZ
            self.gps = self._sample_gps(truth, gps, fix_error)

    @property
    def range_below_m(self) -> float:
        """Distance along the vehicle's down axis to level ground; inf if it points elsewhere."""
        _, x, y, _ = self._truth.attitude
        upright = 1 - 2 * (x * x + y * y)
        above_m = max(0.0, -self._truth.position[2] - self._ground_up_m)
        return above_m / upright if upright > 0 else math.inf

    @property
    def imu(self) -> ImuSample:
        """The newest sample of the inertial unit."""
        return self._imu.at(self._truth)

    @property
    def barometer(self) -> BarometerSample:
        """The newest sample of the barometer."""
        return self._barometer.at(self._truth)

    def _sample_gps(
        self, truth: FlightState, gps: GpsQuality, fix_error: tuple[float, float]
    ) -> GpsFix:
        if gps.is_lost:
            last = self.gps
            return GpsFix(
                truth.time_s,
                False,
                *(last.latitude_deg, last.longitude_deg, last.altitude_m),
                (0.0, 0.0, 0.0),
                0,
                GPS_LOST_ACCURACY_M,
            )
        gauss, noise = self._gps_gauss, self._noise
        north, east, down = truth.position
        latitude_deg, longitude_deg, altitude_m = self._origin.to_global(
            (
                north + fix_error[0] + gauss(0.0, noise.gps_horizontal_m),
                east + fix_error[1] + gauss(0.0, noise.gps_horizontal_m),
                down + gauss(0.0, noise.gps_vertical_m),
            )
        )
        v_n, v_e, v_d = truth.velocity
        speed = noise.gps_speed_mps
        velocity = (v_n + gauss(0.0, speed), v_e + gauss(0.0, speed), v_d + gauss(0.0, speed))
        return GpsFix(
            truth.time_s,
            True,
            *(latitude_deg, longitude_deg, altitude_m),
            velocity,
            gps.satellites,
            math.hypot(GPS_ACCURACY_M, math.sqrt(2) * gps.noise_m),
        )

    def _sample_imu(self, truth: FlightState) -> ImuSample:
        gauss = self._imu_gauss
        force, rate = self._noise.acceleration_mps2, self._noise.rate_radps
        f_x, f_y, f_z = truth.specific_force
        p, q, r = truth.rates
        return ImuSample(
            truth.time_s,
            (f_x + gauss(0.0, force), f_y + gauss(0.0, force), f_z + gauss(0.0, force)),
            (p + gauss(0.0, rate), q + gauss(0.0, rate), r + gauss(0.0, rate)),
        )

    def _sample_barometer(self, truth: FlightState) -> BarometerSample:
        altitude_m = self._origin.altitude_m - truth.position[2]
        kelvin = SEA_TEMPERATURE_K - LAPSE_K_PER_M * altitude_m
        pressure = SEA_PRESSURE_PA * (kelvin / SEA_TEMPERATURE_K) ** PRESSURE_EXPONENT
        pressure += self._barometer_gauss(0.0, self._noise.pressure_pa)
        return BarometerSample(
            truth.time_s, pressure, pressure_altitude_m(pressure), kelvin - CELSIUS_ZERO_K
        )


def pressure_altitude_m(pressure_pa: float) -> float:
    """Height in the International Standard Atmosphere.

    >>> round(pressure_altitude_m(101325.0)), round(pressure_altitude_m(95460.8))
    (0, 500)
    """
    ratio = math.pow(pressure_pa / SEA_PRESSURE_PA, 1 / PRESSURE_EXPONENT)
    return SEA_TEMPERATURE_K / LAPSE_K_PER_M * (1 - ratio)
