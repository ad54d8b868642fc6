"""Speed profiles along a straight leg, under limits of speed, acceleration and jerk.

The quickest change from one speed to another, with zero acceleration at both, has a closed form.
The acceleration rises and falls with the greatest jerk j. It is constant in between if the change
is greater than a^2 / j:

    T = |v1 - v0| / a + a / j,   else   T = 2 sqrt(|v1 - v0| / j);   s = (v0 + v1) / 2 T

by symmetry (Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots, 2008,
section 3.4). From this follow the speed that can be reached within a distance, the distance to a
stop, and the time of a flight from rest to rest. The quickest profile along a leg of given length
between given speeds, also from an acceleration, is Ruckig's (Berscheid and Kroeger, Jerk-limited
Real-time Trajectory Generation with Arbitrary Target States, RSS 2021).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import ruckig

_REST_MPS = 1e-9  # a slower vehicle is at rest


@dataclass(frozen=True, slots=True)
class Motion:
    """A speed, at least 0, and its rate of change."""

    speed_mps: float
    acceleration_mps2: float = 0.0


REST = Motion(0.0)


@dataclass(frozen=True, slots=True)
class SpeedLimits:
    """The greatest speed, acceleration and jerk along a leg, all positive.

    Attributes:
        climb_mps: greatest vertical speed upwards.
        descent_mps: greatest vertical speed downwards.
    """

    speed_mps: float
    acceleration_mps2: float
    jerk_mps3: float
    climb_mps: float = math.inf
    descent_mps: float = math.inf

    def along(self, down: float) -> SpeedLimits:
        """The limits along a direction.

        Args:
            down: vertical component of the unit vector, negative for a climb.

        >>> SpeedLimits(2.0, 2.0, 8.0, descent_mps=0.9).along(0.6).speed_mps
        1.5
        """
        vertical_mps = self.descent_mps if down > 0.0 else self.climb_mps
        if self.speed_mps * abs(down) <= vertical_mps:
            return self
        return replace(self, speed_mps=vertical_mps / abs(down))

    def change_s(self, from_mps: float, to_mps: float) -> float:
        """Least time to change from one speed to another, with zero acceleration at both."""
        change_mps = abs(to_mps - from_mps)
        ramp_s = self.acceleration_mps2 / self.jerk_mps3
        if change_mps <= self.acceleration_mps2 * ramp_s:  # it is not reached
            return 2 * math.sqrt(change_mps / self.jerk_mps3)
        return change_mps / self.acceleration_mps2 + ramp_s

    def change_m(self, from_mps: float, to_mps: float) -> float:
        """The distance flown during such a change."""
        return (from_mps + to_mps) / 2 * self.change_s(from_mps, to_mps)

    def reached_mps(self, from_mps: float, within_m: float) -> float:
        """The greatest speed that can be reached within a distance, up to the limit.

        The inverse of `change_m`: a quadratic in the speed or, if the acceleration is not reached,
        a cubic in the square root of the change.
        """
        if from_mps >= self.speed_mps or within_m <= 0.0:
            return from_mps
        ramped_mps = self.acceleration_mps2**2 / self.jerk_mps3  # the least change with all of it
        if within_m >= (2 * from_mps + ramped_mps) * self.acceleration_mps2 / self.jerk_mps3:
            root = math.hypot(
                from_mps - ramped_mps / 2, math.sqrt(2 * self.acceleration_mps2 * within_m)
            )
            reached_mps = root - ramped_mps / 2
        else:
            root = _cubic_root(2 * from_mps, within_m * math.sqrt(self.jerk_mps3))
            reached_mps = from_mps + root**2
        return min(reached_mps, self.speed_mps)

    def released(self, motion: Motion) -> tuple[float, float]:
        """The speed once the acceleration has been brought to zero, and the distance until then."""
        ramp_s = abs(motion.acceleration_mps2) / self.jerk_mps3
        change_mps = motion.acceleration_mps2 * ramp_s / 2
        distance_m = (motion.speed_mps + change_mps * 2 / 3) * ramp_s
        return motion.speed_mps + change_mps, distance_m

    def braking(self, motion: Motion) -> tuple[float, float]:
        """The speed, without acceleration, at which braking begins, and the distance to that point.

        The distance is negative if the vehicle is braking already: the braking would have begun
        there.
        """
        ramp_s = motion.acceleration_mps2 / self.jerk_mps3
        speed_mps = motion.speed_mps + motion.acceleration_mps2 * ramp_s / 2
        return speed_mps, (motion.speed_mps + self.jerk_mps3 * ramp_s**2 / 3) * ramp_s

    def stop_m(self, motion: Motion) -> float:
        """The shortest distance to a stop.

        >>> SpeedLimits(2.0, 2.0, 8.0).stop_m(Motion(2.0))
        1.25
        """
        speed_mps, ahead_m = self.braking(motion)
        return ahead_m + self.change_m(speed_mps, 0.0)


def flight_time_s(distance_m: float, limits: SpeedLimits) -> float:
    """Time to fly a straight distance from rest to rest; inf for an infinite distance.

    >>> flight_time_s(6.0, SpeedLimits(2.0, 2.0, 8.0))
    4.25
    """
    rise_s = limits.change_s(0.0, limits.speed_mps)
    if distance_m >= limits.speed_mps * rise_s:
        return distance_m / limits.speed_mps + rise_s
    return 2 * limits.change_s(0.0, limits.reached_mps(0.0, distance_m / 2))


def quickest(
    length_m: float, start: Motion, end_mps: float, limits: SpeedLimits
) -> ruckig.Trajectory:
    """The quickest profile along a leg, to a speed without acceleration.

    Raises:
        ArithmeticError: Ruckig finds no profile.
    """
    asked = ruckig.InputParameter(1)
    asked.current_position, asked.target_position = [0.0], [length_m]
    asked.current_velocity, asked.target_velocity = [start.speed_mps], [end_mps]
    asked.current_acceleration, asked.target_acceleration = [start.acceleration_mps2], [0.0]
    asked.max_velocity = [limits.speed_mps]
    asked.max_acceleration, asked.max_jerk = [limits.acceleration_mps2], [limits.jerk_mps3]
    profile = ruckig.Trajectory(1)
    try:
        ruckig.Ruckig(1).calculate(asked, profile)
    except ruckig.RuckigError as error:
        raise ArithmeticError(str(error)) from error
    return profile


def _cubic_root(linear: float, constant: float) -> float:
    """The real root of u^3 + linear u = constant, both at least 0, without cancellation."""
    if linear <= _REST_MPS:
        return math.cbrt(constant)
    scale = 2 * math.sqrt(linear / 3)
    return scale * math.sinh(math.asinh(3 * constant / (linear * scale)) / 3)
