"""Trajectories: position, velocity and heading along a route at each time.

The vehicle follows the legs of a route exactly, from rest (or from a motion along the first leg)
to rest. On each leg the speed changes as fast as the limits of acceleration and jerk allow
(`profile.py`), with no acceleration at the corners. There the direction of the velocity jumps, so
the speed is limited: the jump may not exceed what the vehicle can make up in CORNER_TIME_S,

    |v_after - v_before| = 2 v sin(turn / 2) <= acceleration * CORNER_TIME_S.

A pass forwards over the corners and one backwards make these speeds reachable (the usual
time-optimal scaling along a given path: Biagiotti and Melchiorri, Trajectory Planning for
Automatic Machines and Robots, 2008, chapters 3 and 9). Sampling a trajectory integrates nothing.

The heading turns towards the leg that is flown, at YAW_RATE_RADPS.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from companion.geometry import Ned, wrap_angle
from companion.motion.profile import REST, Motion, SpeedLimits, quickest
from companion.motion.routes import Route

# At 2 m/s2 a jump of 0.3 m/s. PX4's cascade with its default gains, 5 m/s2 at most and the
# setpoint's acceleration fed forward then stays within 0.1 m of the legs (test_trajectory.py).
CORNER_TIME_S = 0.15
YAW_RATE_RADPS = 1.5
AT_REST: Ned = (0.0, 0.0, 0.0)

_MIN_LEG_M = 1e-3  # waypoints nearer than that to the one before are left out
_STRAIGHT = 1e-6  # radians; legs that turn by less are one
_REACH = (
    0.99  # share of a leg that a change of speed may take; profiles that just fit are not found
)
_RUN_OUT = 1.03  # of the shortest distance to a stop; more than 1 / _REACH
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


class Trajectory:
    """A route with a time for each point.

    Args:
        route: the legs to fly.
        limits: of the speed along them.
        yaw_rad: heading before the first leg.
        start: motion at the start, along the first leg; lowered to what the route allows.

    Attributes:
        duration_s: time from the start to the end at rest.
    """

    duration_s: float

    def __init__(
        self, route: Route, limits: SpeedLimits, yaw_rad: float = 0.0, start: Motion = REST
    ) -> None:
        waypoints = _corners(route.waypoints)
        legs = np.diff(waypoints, axis=0)
        lengths = np.linalg.norm(legs, axis=1)
        self._end = _ned(route.waypoints[-1])
        self._corners = waypoints[:-1]
        self._directions = legs / lengths[:, None]
        each = [limits.along(down) for _, _, down in self._directions.tolist()]
        motions = _corner_motions(self._directions, lengths.tolist(), start, each)
        self._profiles = [
            quickest(length, before, after.speed_mps, along)
            for length, (before, after), along in zip(
                lengths.tolist(), pairwise(motions), each, strict=True
            )
        ]
        self._begin_s = [0.0]
        for profile in self._profiles:
            self._begin_s.append(self._begin_s[-1] + profile.duration)
        self.duration_s = self._begin_s.pop()
        self._turns = _turns(self._directions, self._begin_s, yaw_rad)

    def sample(self, t_s: float) -> Sample:
        """Position, velocity and heading at a time since the start.

        Args:
            t_s: seconds; before 0 the start, after the duration the end, at rest.
        """
        t_s = max(0.0, t_s)
        yaw_rad = self._yaw(t_s)
        if t_s >= self.duration_s:
            return Sample(self._end, AT_REST, AT_REST, yaw_rad, True)
        leg = self._leg(t_s)
        (along,), (speed,), (change,) = self._profiles[leg].at_time(t_s - self._begin_s[leg])
        direction = self._directions[leg]
        return Sample(
            _ned(self._corners[leg] + along * direction),
            _ned(speed * direction),
            _ned(change * direction),
            yaw_rad,
            False,
        )

    def ahead(self, t_s: float) -> npt.NDArray[np.float64]:
        """(n, 3) points of the legs that are left at a time, n >= 2."""
        t_s = max(0.0, t_s)
        here = self.sample(t_s).position
        if t_s >= self.duration_s:
            return np.array([here, self._end])
        return np.vstack([here, self._corners[self._leg(t_s) + 1 :], self._end])

    def _leg(self, t_s: float) -> int:
        """The leg that is flown at a time from the start on, before the end."""
        return bisect_right(self._begin_s, t_s) - 1

    def _yaw(self, t_s: float) -> float:
        """The heading: from that at the leg's beginning towards the leg, at a limited rate."""
        latest = bisect_right(self._turns, t_s, key=lambda turn: turn[0]) - 1
        begin_s, from_rad, turn_rad = self._turns[latest]
        return wrap_angle(from_rad + _limited(turn_rad, YAW_RATE_RADPS * (t_s - begin_s)))


def motion_of(velocity: Ned, acceleration: Ned) -> Motion:
    """The motion along a velocity."""
    speed_mps = math.hypot(*velocity)
    if speed_mps == 0.0:
        return REST
    along = sum(v * a for v, a in zip(velocity, acceleration, strict=True))
    return Motion(speed_mps, along / speed_mps)


def run_out(position: Ned, velocity: Ned, acceleration: Ned, limits: SpeedLimits) -> Ned:
    """The point straight ahead where a moving vehicle can come to rest, with a little room.

    >>> north, *_ = run_out((0.0, 0.0, -2.0), (2.0, 0.0, 0.0), AT_REST, SpeedLimits(2.0, 2.0, 8.0))
    >>> round(north, 3)
    1.288
    """
    motion = motion_of(velocity, acceleration)
    if motion.speed_mps == 0.0:
        return position
    per_mps = _RUN_OUT * limits.stop_m(motion) / motion.speed_mps
    north, east, down = (p + v * per_mps for p, v in zip(position, velocity, strict=True))
    return (north, east, down)


def _corners(waypoints: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """The waypoints at which the route begins, turns or ends; the end alone if it has no length."""
    kept = [waypoints[0]]
    for waypoint in waypoints[1:-1]:
        if np.linalg.norm(waypoint - kept[-1]) >= _MIN_LEG_M:
            kept.append(waypoint)
    while kept and np.linalg.norm(waypoints[-1] - kept[-1]) < _MIN_LEG_M:
        kept.pop()
    points = np.array([*kept, waypoints[-1]])
    legs = np.diff(points, axis=0)
    directions = legs / np.linalg.norm(legs, axis=1)[:, None]
    is_turn = np.linalg.norm(np.diff(directions, axis=0), axis=1) > _STRAIGHT
    inner = np.flatnonzero(is_turn) + 1
    return np.asarray(points[np.unique([0, *inner.tolist(), len(points) - 1])])


def _corner_motions(
    directions: npt.NDArray[np.float64],
    lengths_m: list[float],
    start: Motion,
    limits: list[SpeedLimits],
) -> list[Motion]:
    """The motion at the beginning of each leg and at the end of the last, which is at rest.

    Args:
        limits: along each leg.
    """
    if not lengths_m:
        return [REST]
    half_jump = np.linalg.norm(np.diff(directions, axis=0), axis=1) / 2  # sin(turn / 2)
    first = limits[0]
    corners = first.acceleration_mps2 * CORNER_TIME_S / (2 * np.maximum(half_jump, 1e-9))
    legs = [min(a.speed_mps, b.speed_mps) for a, b in pairwise(limits)]
    max_mps = [*np.minimum(corners, legs).tolist(), 0.0]
    rooms_m = [_REACH * length_m for length_m in lengths_m]
    start = Motion(min(start.speed_mps, first.speed_mps), start.acceleration_mps2)
    ends = _reachable(max_mps, rooms_m, start, limits)
    if not _can_brake(start, ends[0], rooms_m[0], first):  # a stop takes less room
        ends = _reachable([0.0, *max_mps[1:]], rooms_m, start, limits)
    if not _can_brake(start, ends[0], rooms_m[0], first):
        start = Motion(min(start.speed_mps, first.reached_mps(ends[0], rooms_m[0])))
    return [start, *map(Motion, ends)]


def _reachable(
    max_mps: list[float], rooms_m: list[float], start: Motion, limits: list[SpeedLimits]
) -> list[float]:
    """The greatest speeds at the ends of legs, each reachable from those beside it."""
    ends = max_mps.copy()
    speed_mps, used_m = limits[0].released(start)
    for leg, room_m in enumerate(rooms_m):
        is_room = room_m > used_m
        reached_mps = limits[leg].reached_mps(speed_mps, room_m - used_m) if is_room else 0.0
        speed_mps, used_m = min(ends[leg], reached_mps), 0.0
        ends[leg] = speed_mps
    for leg in range(len(ends) - 1, 0, -1):
        ends[leg - 1] = min(ends[leg - 1], limits[leg].reached_mps(ends[leg], rooms_m[leg]))
    return ends


def _can_brake(start: Motion, end_mps: float, room_m: float, limits: SpeedLimits) -> bool:
    """Whether a start on the first leg leaves room to slow down to its end."""
    released_mps, _ = limits.released(start)
    if end_mps >= released_mps:
        return True
    speed_mps, ahead_m = limits.braking(start)
    return ahead_m + limits.change_m(speed_mps, end_mps) <= room_m


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


def _limited(angle_rad: float, max_rad: float) -> float:
    return math.copysign(min(abs(angle_rad), max_rad), angle_rad)


def _ned(vector: npt.NDArray[np.float64]) -> Ned:
    north, east, down = vector.tolist()
    return (north, east, down)
