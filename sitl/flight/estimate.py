"""The autopilot's estimate of the vehicle's state: the truth, plus the errors of GPS.

In: the true state each step, and the quality of GPS now. Out: the state that the autopilot flies by
and reports. Three cases:

    good GPS       the truth itself, the same object
    noisy GPS      north and east wander slowly: a first-order Gauss-Markov process of deviation
                   `noise_m` and correlation time 60 s, e' = -e / tau + white noise
    GPS lost       dead reckoning: the velocity's error is a random walk of 0.1 m/s per root of a
                   second, so the position's deviation grows as 0.1 sqrt(t^3 / 3)

A fix after a loss takes the estimate back at once, as PX4's estimator resets its position. Height
comes from the barometer, attitude and rates from inertial sensors: they stay true.

Source: Gauss-Markov errors of GPS after Parkinson and Spilker, Global Positioning System, vol. 1.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass

from sitl.flight.physics import FlightState

WANDER_S = 60.0
VELOCITY_WALK = 0.1  # m/s per sqrt(s): a calm consumer IMU without a magnetometer's help
NEGLIGIBLE_M = 1e-3


@dataclass(frozen=True, slots=True)
class GpsQuality:
    """The quality of GPS.

    Attributes:
        is_lost: no fix.
        noise_m: standard deviation of north and of east.
        satellites: used by the receiver.
    """

    is_lost: bool = False
    noise_m: float = 0.0
    satellites: int = 10


class Estimator:
    """The estimate of one vehicle.

    Args:
        rng: of the errors.
        gps: at the start.

    Attributes:
        gps: may be replaced in flight.
        error: of the estimated position, north and east.
        fix_error: of the receiver's fix; while there is none, that of a fix.
        time_since_fix_s: time since the last fix, 0 with one.
    """

    def __init__(self, rng: random.Random, gps: GpsQuality = GpsQuality()) -> None:
        self.gps = gps
        self.fix_error = (rng.gauss(0.0, gps.noise_m), rng.gauss(0.0, gps.noise_m))
        self.error = self.fix_error
        self.time_since_fix_s = 0.0
        self._rng = rng
        self._velocity_error = (0.0, 0.0)
        self._now_s: float | None = None

    def step(self, truth: FlightState, now_s: float) -> FlightState:
        """The estimate at a time; the first call only sets the clock."""
        dt_s = 0.0 if self._now_s is None else now_s - self._now_s
        self._now_s = now_s
        gps = self.gps
        if gps.noise_m > 0 or self.fix_error != (0.0, 0.0):
            self._step_fix_error(gps.noise_m, dt_s)
        if gps.is_lost:
            self.time_since_fix_s += dt_s
            self._dead_reckon(dt_s)
        else:
            self.time_since_fix_s = 0.0
            self.error, self._velocity_error = self.fix_error, (0.0, 0.0)
            if self.error == (0.0, 0.0):
                return truth
        return self._with_errors(truth)

    def _step_fix_error(self, noise_m: float, dt_s: float) -> None:
        keep = math.exp(-dt_s / WANDER_S)
        kick = noise_m * math.sqrt(1 - keep * keep)
        gauss = self._rng.gauss
        north, east = self.fix_error
        self.fix_error = (north * keep + gauss(0.0, kick), east * keep + gauss(0.0, kick))
        if noise_m == 0 and math.hypot(*self.fix_error) < NEGLIGIBLE_M:
            self.fix_error = (0.0, 0.0)

    def _dead_reckon(self, dt_s: float) -> None:
        kick = VELOCITY_WALK * math.sqrt(dt_s)
        gauss = self._rng.gauss
        (north, east), (v_n, v_e) = self.error, self._velocity_error
        self.error = (north + v_n * dt_s, east + v_e * dt_s)
        self._velocity_error = (v_n + gauss(0.0, kick), v_e + gauss(0.0, kick))

    def _with_errors(self, truth: FlightState) -> FlightState:
        north, east, down = truth.position
        v_n, v_e, v_d = truth.velocity
        (e_n, e_e), (e_vn, e_ve) = self.error, self._velocity_error
        return FlightState(
            truth.time_s,
            (north + e_n, east + e_e, down),
            (v_n + e_vn, v_e + e_ve, v_d),
            truth.attitude,
            truth.euler,
            truth.rates,
            truth.specific_force,
            truth.motor_speed_radps,
            truth.voltage_v,
            truth.current_a,
            truth.charge,
            truth.is_on_ground,
        )
