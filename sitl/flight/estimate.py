"""The autopilot's estimate of the vehicle's state: the truth, plus the errors of GPS.

In: the true state at each step, and the present quality of GPS. Out: the state that the autopilot
flies by and reports. Four cases:

    good GPS       the truth itself, the same object
    noisy GPS      north and east wander slowly: a first-order Gauss-Markov process of deviation
                   `noise_m` and correlation time 60 s, e' = -e / tau + white noise
    wander         the velocity error v is such a process too, and the position error integrates
                   it while fixes pull it back: e' = v - e / T. Both have the same time constant,
                   which follows from the two deviations: T = sqrt(2) sd(e) / sd(v). This is how
                   PX4's filter, which fuses white noise, looks from outside. If the height
                   wanders too, its T is 20 s
    GPS lost       dead reckoning: the velocity error is a random walk of 0.1 m/s per root of a
                   second, so the deviation of the position grows as 0.1 sqrt(t^3 / 3)

1. The reported accuracy is the root of the sum of these variances and of CLAIMED_M, the accuracy
   that a filter with a perfect receiver reports.
2. A fix after a loss corrects the estimate at once, as PX4's estimator resets its position.
3. Height comes from the barometer. It is exact, unless the scenario asks for wander; as in PX4, the
   reported accuracy of the height does not show this error.
4. Attitude and rates come from inertial sensors and are exact.
5. A jump shifts position and fixes for good, as after a reset to a wrong receiver or barometer.

Source: Gauss-Markov errors of GPS after Parkinson and Spilker, Global Positioning System, vol. 1.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass

from companion.geometry import Ned
from sitl.flight.physics import FlightState

WANDER_S = 60.0
HEIGHT_S = 20.0
VELOCITY_WALK = 0.1  # m/s per sqrt(s): a calm consumer IMU without a magnetometer's help
CLAIMED_M = 0.05  # as with motion capture, or a receiver with corrections (RTK)
NEGLIGIBLE_M = 1e-3


@dataclass(frozen=True, slots=True)
class GpsQuality:
    """The quality of GPS.

    Attributes:
        is_lost: there is no fix.
        noise_m: standard deviation of north and of east.
        satellites: used by the receiver.
    """

    is_lost: bool = False
    noise_m: float = 0.0
    satellites: int = 10


@dataclass(frozen=True, slots=True)
class Wander:
    """How far the estimate wanders although the receiver has a fix.

    Attributes:
        position_m: root mean square of the position error, north and east together.
        velocity_mps: root mean square of the velocity error.
        height_m: root mean square of the height error; the error of the vertical velocity follows
            from it.
    """

    position_m: float
    velocity_mps: float
    height_m: float = 0.0

    def level_error(self, rng: random.Random) -> WanderingError:
        """The errors of north and east."""
        time_s = math.sqrt(2) * self.position_m / self.velocity_mps
        return WanderingError(2, self.velocity_mps / math.sqrt(2), time_s, rng)

    def height_error(self, rng: random.Random) -> WanderingError | None:
        """The error of down; None where the height is exact."""
        if not self.height_m:
            return None
        return WanderingError(1, math.sqrt(2) * self.height_m / HEIGHT_S, HEIGHT_S, rng)


class WanderingError:
    """Wandering errors of one or more coordinates, which start in their stationary distribution.

    Args:
        axes: number of coordinates.
        velocity_mps: standard deviation of the error of each coordinate's velocity.
        time_s: the time constant.
        rng: source of the errors.

    Attributes:
        position, velocity: (axes,) the present errors.
    """

    def __init__(self, axes: int, velocity_mps: float, time_s: float, rng: random.Random) -> None:
        self._axes, self._time_s, self._rng = axes, time_s, rng
        self._velocity_sd = velocity_mps
        self.velocity = self._draw(self._velocity_sd)
        # Correlated as in the stationary state: E[e v] = sd(v)^2 T / 2.
        half, rest = time_s / 2, self._draw(self._velocity_sd * time_s / 2)
        self.position = tuple(half * v + r for v, r in zip(self.velocity, rest, strict=True))

    def step(self, dt_s: float) -> None:
        """Advances the errors by a time step."""
        keep = math.exp(-dt_s / self._time_s)
        kick = self._draw(self._velocity_sd * math.sqrt(1 - keep * keep))
        before = zip(self.position, self.velocity, strict=True)
        self.position = tuple(e * keep + v * dt_s for e, v in before)
        self.velocity = tuple(v * keep + k for v, k in zip(self.velocity, kick, strict=True))

    def _draw(self, deviation: float) -> tuple[float, ...]:
        return tuple(self._rng.gauss(0.0, deviation) for _ in range(self._axes))


class Estimator:
    """The estimate of one vehicle.

    Args:
        rng: source of the errors.
        gps: at the start.
        wander: how the estimate wanders; None means not at all.

    Attributes:
        gps: may be replaced in flight.
        error: the error of the estimated position, north and east.
        fix_error: the error of the receiver's fix, or the one that a fix would have.
        resets: how often the position was reset.
        time_since_fix_s: time since the last fix; 0 with a fix.
    """

    def __init__(
        self,
        rng: random.Random,
        gps: GpsQuality = GpsQuality(),
        wander: Wander | None = None,
    ) -> None:
        self.gps = gps
        self.time_since_fix_s = 0.0
        self.resets = 0
        self._noise = (rng.gauss(0.0, gps.noise_m), rng.gauss(0.0, gps.noise_m))
        self._jumped: Ned = (0.0, 0.0, 0.0)
        self.fix_error = self._noise
        self.error = self.fix_error
        self._rng = rng
        self._wandering = wander.level_error(rng) if wander else None
        self._wander_m = wander.position_m if wander else 0.0
        self._height = wander.height_error(rng) if wander else None
        self._velocity_error = (0.0, 0.0)
        self._now_s: float | None = None

    @property
    def accuracy_m(self) -> float:
        """The reported accuracy of the horizontal position: one standard deviation, m."""
        drift_m = VELOCITY_WALK * math.sqrt(2 * self.time_since_fix_s**3 / 3)
        return math.hypot(CLAIMED_M, self._wander_m, math.sqrt(2) * self.gps.noise_m, drift_m)

    def jump(self, by: Ned) -> None:
        """Shifts the estimated position and the receiver's fixes at once."""
        (north, east, down), (by_n, by_e, by_d) = self._jumped, by
        self._jumped = (north + by_n, east + by_e, down + by_d)
        self._place_fix()
        self.error = (self.error[0] + by_n, self.error[1] + by_e)
        self.resets += 1

    def step(self, truth: FlightState, now_s: float) -> FlightState:
        """The estimate at a time; the first call only starts the clock."""
        dt_s = 0.0 if self._now_s is None else now_s - self._now_s
        self._now_s = now_s
        gps = self.gps
        if gps.noise_m > 0 or self._noise != (0.0, 0.0):
            self._step_noise(gps.noise_m, dt_s)
        if self._height is not None:
            self._height.step(dt_s)
        if gps.is_lost:
            self.time_since_fix_s += dt_s
            self._dead_reckon(dt_s)
        else:
            self.resets += self.time_since_fix_s > 0
            self.time_since_fix_s = 0.0
            self.error, self._velocity_error = self.fix_error, (0.0, 0.0)
            if self._wandering is not None:
                self._wander(self._wandering, dt_s)
        return self.seen(truth)

    def _wander(self, wandering: WanderingError, dt_s: float) -> None:
        wandering.step(dt_s)
        (north, east), (e_n, e_e) = self.fix_error, wandering.position
        self.error = (north + e_n, east + e_e)
        v_n, v_e = wandering.velocity
        self._velocity_error = (v_n, v_e)

    def _step_noise(self, noise_m: float, dt_s: float) -> None:
        keep = math.exp(-dt_s / WANDER_S)
        kick = noise_m * math.sqrt(1 - keep * keep)
        gauss = self._rng.gauss
        north, east = self._noise
        self._noise = (north * keep + gauss(0.0, kick), east * keep + gauss(0.0, kick))
        if noise_m == 0 and math.hypot(*self._noise) < NEGLIGIBLE_M:
            self._noise = (0.0, 0.0)
        self._place_fix()

    def _place_fix(self) -> None:
        self.fix_error = (self._noise[0] + self._jumped[0], self._noise[1] + self._jumped[1])

    def _dead_reckon(self, dt_s: float) -> None:
        kick = VELOCITY_WALK * math.sqrt(dt_s)
        gauss = self._rng.gauss
        (north, east), (v_n, v_e) = self.error, self._velocity_error
        self.error = (north + v_n * dt_s, east + v_e * dt_s)
        self._velocity_error = (v_n + gauss(0.0, kick), v_e + gauss(0.0, kick))

    def seen(self, truth: FlightState) -> FlightState:
        """The estimate of a true state, with the errors of the last step."""
        height = self._height
        is_level_true = self.error == (0.0, 0.0) == self._velocity_error
        if is_level_true and height is None and not self._jumped[2]:
            return truth
        e_d, e_vd = (height.position[0], height.velocity[0]) if height is not None else (0.0, 0.0)
        north, east, down = truth.position
        v_n, v_e, v_d = truth.velocity
        (e_n, e_e), (e_vn, e_ve) = self.error, self._velocity_error
        return FlightState(
            truth.time_s,
            (north + e_n, east + e_e, down + self._jumped[2] + e_d),
            (v_n + e_vn, v_e + e_ve, v_d + e_vd),
            truth.attitude,
            truth.euler,
            truth.rates,
            truth.specific_force,
            truth.motors,
            truth.motor_speed_radps,
            truth.voltage_v,
            truth.current_a,
            truth.charge,
            truth.is_on_ground,
        )
