"""Trajectories: where along its route should the vehicle be at a time, and how fast?

The vehicle follows the legs of a route exactly, from rest (or from a speed along the first leg)
to rest. On each leg the speed is a
trapezoid: it rises at the greatest acceleration, holds, and falls. At a corner the direction of
the velocity jumps, so the speed there is limited: the jump may not exceed what the vehicle can
make up in CORNER_TIME_S,

    |v_after - v_before| = 2 v sin(turn / 2) <= acceleration * CORNER_TIME_S.

A pass forwards over the corners and one backwards make these speeds reachable (the usual
time-optimal scaling along a given path: Biagiotti and Melchiorri, Trajectory Planning for
Automatic Machines and Robots, 2008, chapters 3 and 9). All phases are in closed form: sampling
a trajectory integrates nothing.

The heading turns towards the leg that is flown, at YAW_RATE_RADPS. Left out: limits of jerk.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from companion.geometry import Ned, wrap_angle
from companion.motion.routes import Route

# At 2 m/s2 a jump of 0.3 m/s. PX4's cascade with its default gains, 5 m/s2 at most and the
# setpoint's acceleration fed forward then stays within 0.1 m of the legs (test_trajectory.py).
CORNER_TIME_S = 0.15
YAW_RATE_RADPS = 1.5
AT_REST: Ned = (0.0, 0.0, 0.0)

_MIN_LEG_M = 1e-9  # shorter legs have no direction
_MIN_LEVEL_SHARE = 1e-3  # of a leg; a steeper leg has no heading


@dataclass(frozen=True, slots=True)
class Sample:
    """A moment of a trajectory, in the mission's frame.

    Attributes:
        acceleration: along the leg, for feed-forward; a tracker without it lags behind.
        yaw_rad: heading, 0 is north, positive to the east, in (-pi, pi].
        is_finished: the end of the route has been reached, at rest.
    """

    position: Ned
    velocity: Ned
    acceleration: Ned
    yaw_rad: float
    is_finished: bool


@dataclass(frozen=True, slots=True)
class _Phase:
    """A part of a leg with constant acceleration along it."""

    leg: int
    begin_s: float
    along_m: float  # from the beginning of the leg
    speed_mps: float
    acceleration_mps2: float


class Trajectory:
    """A route with a time for each point.

    Args:
        route: the legs to fly.
        speed_mps: greatest speed, positive.
        acceleration_mps2: greatest acceleration along a leg, positive.
        yaw_rad: heading before the first leg.
        start_mps: speed at the start, along the first leg; lowered to what the route allows.

    Attributes:
        duration_s: time from the start to the end at rest.
    """

    duration_s: float

    def __init__(
        self,
        route: Route,
        speed_mps: float,
        acceleration_mps2: float,
        yaw_rad: float = 0.0,
        start_mps: float = 0.0,
    ) -> None:
        legs = np.diff(route.waypoints, axis=0)
        lengths = np.linalg.norm(legs, axis=1)
        is_leg = lengths > _MIN_LEG_M
        self._end = _ned(route.waypoints[-1])
        self._corners = route.waypoints[:-1][is_leg]
        self._directions = legs[is_leg] / lengths[is_leg, None]
        speeds = _corner_speeds(
            self._directions,
            lengths[is_leg],
            min(start_mps, speed_mps),
            speed_mps,
            acceleration_mps2,
        )
        self._phases: list[_Phase] = []
        self.duration_s = 0.0
        leg_begin_s = []
        for leg, length in enumerate(lengths[is_leg].tolist()):
            leg_begin_s.append(self.duration_s)
            self._add_leg(leg, length, speeds[leg : leg + 2], speed_mps, acceleration_mps2)
        self._begin_s = [phase.begin_s for phase in self._phases]
        self._turns = _turns(self._directions, leg_begin_s, yaw_rad)

    def sample(self, t_s: float) -> Sample:
        """Position, velocity and heading at a time since the start.

        Args:
            t_s: seconds; before 0 the start, after the duration the end, both at rest.
        """
        t_s = max(0.0, t_s)
        yaw_rad = self._yaw(t_s)
        if t_s >= self.duration_s:
            return Sample(self._end, AT_REST, AT_REST, yaw_rad, True)
        phase = self._phases[bisect_right(self._begin_s, t_s) - 1]
        dt_s = t_s - phase.begin_s
        speed = phase.speed_mps + phase.acceleration_mps2 * dt_s
        along = phase.along_m + (phase.speed_mps + speed) / 2 * dt_s
        direction = self._directions[phase.leg]
        return Sample(
            _ned(self._corners[phase.leg] + along * direction),
            _ned(speed * direction),
            _ned(phase.acceleration_mps2 * direction),
            yaw_rad,
            False,
        )

    def ahead(self, t_s: float) -> npt.NDArray[np.float64]:
        """(n, 3) points of the legs that are left at a time, n >= 2."""
        t_s = max(0.0, t_s)
        here = self.sample(t_s).position
        if t_s >= self.duration_s:
            return np.array([here, self._end])
        leg = self._phases[bisect_right(self._begin_s, t_s) - 1].leg
        return np.vstack([here, self._corners[leg + 1 :], self._end])

    def _add_leg(
        self,
        leg: int,
        length_m: float,
        ends_mps: list[float],
        speed_mps: float,
        acceleration_mps2: float,
    ) -> None:
        """Append the phases of a leg between the speeds at its two ends."""
        first, last = ends_mps
        reachable = math.sqrt(acceleration_mps2 * length_m + (first**2 + last**2) / 2)
        peak = max(first, last, min(speed_mps, reachable))
        rise_s, fall_s = (peak - first) / acceleration_mps2, (peak - last) / acceleration_mps2
        rise_m, fall_m = (first + peak) / 2 * rise_s, (peak + last) / 2 * fall_s
        hold_m = max(0.0, length_m - rise_m - fall_m)
        for along_m, begin_mps, change_mps2, lasts_s in (
            (0.0, first, acceleration_mps2, rise_s),
            (rise_m, peak, 0.0, hold_m / peak),
            (rise_m + hold_m, peak, -acceleration_mps2, fall_s),
        ):
            if lasts_s > 0:
                self._phases.append(_Phase(leg, self.duration_s, along_m, begin_mps, change_mps2))
                self.duration_s += lasts_s

    def _yaw(self, t_s: float) -> float:
        """The heading: from that at the leg's beginning towards the leg, at a limited rate."""
        latest = bisect_right(self._turns, t_s, key=lambda turn: turn[0]) - 1
        begin_s, from_rad, turn_rad = self._turns[latest]
        return wrap_angle(from_rad + _limited(turn_rad, YAW_RATE_RADPS * (t_s - begin_s)))


def run_out(position: Ned, velocity: Ned, acceleration_mps2: float) -> Ned:
    """Where a moving vehicle can come to rest, straight ahead.

    >>> run_out((0.0, 0.0, -2.0), (2.0, 0.0, 0.0), 2.0)
    (1.0, 0.0, -2.0)
    """
    per_mps = math.hypot(*velocity) / (2 * acceleration_mps2)
    north, east, down = (p + v * per_mps for p, v in zip(position, velocity, strict=True))
    return (north, east, down)


def flight_time_s(distance_m: float, speed_mps: float, acceleration_mps2: float) -> float:
    """Time to fly a straight distance from rest to rest; inf for an infinite distance.

    >>> flight_time_s(6.0, 2.0, 1.0)
    5.0
    >>> flight_time_s(1.0, 2.0, 1.0)
    2.0
    """
    if distance_m < speed_mps**2 / acceleration_mps2:  # the greatest speed is not reached
        return 2 * math.sqrt(distance_m / acceleration_mps2)
    return distance_m / speed_mps + speed_mps / acceleration_mps2


def _corner_speeds(
    directions: npt.NDArray[np.float64],
    lengths_m: npt.NDArray[np.float64],
    start_mps: float,
    speed_mps: float,
    acceleration_mps2: float,
) -> list[float]:
    """Speed at the beginning of each leg and at the end of the last, which is at rest."""
    half_jump = np.linalg.norm(np.diff(directions, axis=0), axis=1) / 2  # sin(turn / 2)
    corners = acceleration_mps2 * CORNER_TIME_S / (2 * np.maximum(half_jump, 1e-9))
    speeds = [start_mps, *np.minimum(corners, speed_mps).tolist(), 0.0]
    gains = (2 * acceleration_mps2 * lengths_m).tolist()  # of the square of the speed
    for leg, gain in enumerate(gains):
        speeds[leg + 1] = min(speeds[leg + 1], math.sqrt(speeds[leg] ** 2 + gain))
    for leg, gain in reversed(list(enumerate(gains))):
        speeds[leg] = min(speeds[leg], math.sqrt(speeds[leg + 1] ** 2 + gain))
    return speeds


def _turns(
    directions: npt.NDArray[np.float64], leg_begin_s: list[float], yaw_rad: float
) -> list[tuple[float, float, float]]:
    """For each leg with a heading: when it begins, the heading then, and the turn to make."""
    turns = [(0.0, wrap_angle(yaw_rad), 0.0)]
    for (north, east, _), begin_s in zip(directions.tolist(), leg_begin_s, strict=True):
        if math.hypot(north, east) < _MIN_LEVEL_SHARE:
            continue
        last_s, last_rad, last_turn_rad = turns[-1]
        now_rad = last_rad + _limited(last_turn_rad, YAW_RATE_RADPS * (begin_s - last_s))
        turns.append((begin_s, now_rad, wrap_angle(math.atan2(east, north) - now_rad)))
    return turns


def _limited(angle_rad: float, most_rad: float) -> float:
    return math.copysign(min(abs(angle_rad), most_rad), angle_rad)


def _ned(vector: npt.NDArray[np.float64]) -> Ned:
    north, east, down = vector.tolist()
    return (north, east, down)
