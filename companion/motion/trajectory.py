"""Trajectories: position, velocity and heading along a route at each time.

1. The vehicle follows the route exactly, from rest (or from a motion along the first leg) to rest.
2. On each leg the speed changes as fast as the limits of acceleration and jerk allow
   (`profile.py`), with zero acceleration at both ends.
3. Each rounded corner (`blends.py`) is flown at the greatest constant speed that these limits allow
   laterally. At a corner that is not rounded the vehicle stops.
4. So neither velocity nor acceleration jumps.

A forward and a backward pass over the corners make these speeds reachable (the usual time-optimal
scaling along a given path: Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and
Robots, 2008, chapters 3 and 9). Sampling a trajectory integrates nothing.

A sample gives the direction of the leg; how the vehicle turns is decided elsewhere.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, pairwise

import numpy as np
import numpy.typing as npt
import ruckig

from companion.geometry import Ned, moved, times
from companion.motion.blends import ned_of
from companion.motion.path import Path, StraightLeg, Turn
from companion.motion.profile import REST, Motion, SpeedLimits, quickest
from companion.motion.routes import Route

AT_REST: Ned = (0.0, 0.0, 0.0)

_REACH = 0.99  # share of a leg for a change of speed; an exact fit is not found
_RUN_OUT = 1.03  # times the shortest distance to a stop; more than 1 / _REACH
_MIN_LEVEL_SHARE = 1e-3  # of a leg; a steeper leg gives no heading


@dataclass(frozen=True, slots=True)
class Sample:
    """A moment of a trajectory, in the mission's frame.

    Attributes:
        acceleration: for feed-forward; without it a controller lags behind.
        against_drag: the acceleration that the drag of the air takes, to be fed forward as well.
        is_finished: whether the end of the route has been reached, at rest.
        course_rad: direction of the leg over ground, 0 is north, positive to the east, in (-pi,
            pi]; None before the first leg that is not too steep.
    """

    position: Ned
    velocity: Ned
    acceleration: Ned
    is_finished: bool
    course_rad: float | None = None
    against_drag: Ned = AT_REST

    @property
    def fed_forward(self) -> Ned:
        """The acceleration to send."""
        return moved(self.acceleration, self.against_drag, 1.0)

    def slower(self, rate: float) -> Sample:
        """The same moment if the trajectory's time runs at another rate.

        Drag is proportional to the speed, acceleration to its square.
        """
        if rate == 1.0:
            return self
        return replace(
            self,
            velocity=times(self.velocity, rate),
            acceleration=times(self.acceleration, rate**2),
            against_drag=times(self.against_drag, rate),
        )


class Trajectory:
    """A route with a time for each point.

    Args:
        route: the legs to fly.
        limits: of the speed along them.
        start: motion at the start, along the first leg; reduced to what the route allows.

    Attributes:
        duration_s: time from the start to the end at rest.
        path: the path that is flown.
    """

    duration_s: float

    def __init__(self, route: Route, limits: SpeedLimits, start: Motion = REST) -> None:
        self._end = ned_of(route.waypoints[-1])
        self.path, self._profiles = _flown(route, limits, start)
        self._begin_s = [0.0, *accumulate(profile.duration for profile in self._profiles)]
        self.duration_s = self._begin_s.pop()
        self._courses = _courses(self.path.pieces, self._begin_s)

    def sample(self, t_s: float) -> Sample:
        """Position, velocity and course at a time since the start.

        Args:
            t_s: seconds; the start before 0, the end at rest after the duration.
        """
        t_s = max(0.0, t_s)
        course_rad = self._course(t_s)
        if t_s >= self.duration_s:
            return Sample(self._end, AT_REST, AT_REST, True, course_rad)
        return sample_at(self.path, *self.progress(t_s), course_rad=course_rad)

    def progress(self, t_s: float) -> tuple[float, Motion]:
        """The distance along the path at a time, and the motion there."""
        t_s = max(0.0, t_s)
        if t_s >= self.duration_s:
            return self.path.length_m, REST
        piece = bisect_right(self._begin_s, t_s) - 1
        (along_m,), (mps,), (mps2,) = self._profiles[piece].at_time(t_s - self._begin_s[piece])
        return self.path.begin_m(piece) + along_m, Motion(mps, mps2)

    def ahead(self, t_s: float) -> npt.NDArray[np.float64]:
        """(n, 3) points of the path that remains at a time, n >= 2."""
        return self.path.ahead(self.progress(t_s)[0])

    def between(self, begin_s: float, end_s: float) -> npt.NDArray[np.float64]:
        """(n, 3) points of the path that is flown from one time to another, n >= 2."""
        return self.path.between(self.progress(begin_s)[0], self.progress(end_s)[0])

    def _course(self, t_s: float) -> float | None:
        """The course of the latest leg that has one."""
        begun = bisect_right(self._courses, t_s, key=lambda course: course[0])
        return self._courses[begun - 1][1] if begun else None


class Stop:
    """The way to rest along the path of a trajectory that is given up.

    Args:
        trajectory: the trajectory that was flown until now.
        t_s: its present time.
        motion: the present motion along its path, which may be slower than the trajectory's.
        limits: the limits of the stop.

    Attributes:
        duration_s: time to the end at rest.
    """

    duration_s: float

    def __init__(
        self, trajectory: Trajectory, t_s: float, motion: Motion, limits: SpeedLimits
    ) -> None:
        self._trajectory, self._begin_s = trajectory, t_s
        self._begin_m, _ = trajectory.progress(t_s)
        stop_m = _RUN_OUT * limits.stop_m(motion)
        self._profile: ruckig.Trajectory | None = None
        self.duration_s = max(0.0, trajectory.duration_s - t_s)
        if self._begin_m + stop_m < trajectory.path.length_m:
            self._profile = quickest(stop_m, motion, 0.0, limits)
            self.duration_s = self._profile.duration

    def sample(self, t_s: float) -> Sample:
        """Like that of a trajectory, at a time since the stop began."""
        if self._profile is None:
            return self._trajectory.sample(self._begin_s + t_s)
        (along_m,), (mps,), (mps2,) = self._profile.at_time(min(t_s, self.duration_s))
        path, is_finished = self._trajectory.path, t_s >= self.duration_s
        motion = REST if is_finished else Motion(mps, mps2)
        return sample_at(path, self._begin_m + along_m, motion, is_finished=is_finished)


def sample_at(
    path: Path,
    along_m: float,
    motion: Motion,
    *,
    is_finished: bool = False,
    course_rad: float | None = None,
) -> Sample:
    """The sample for a vehicle that passes a point of a path."""
    position, direction, curvature = path.at(along_m)
    along, across = motion.acceleration_mps2, motion.speed_mps**2
    change = moved(times(direction, along), curvature, across)
    return Sample(position, times(direction, motion.speed_mps), change, is_finished, course_rad)


def motion_of(velocity: Ned, acceleration: Ned) -> Motion:
    """The motion along the direction of a velocity."""
    speed_mps = math.hypot(*velocity)
    if speed_mps == 0.0:
        return REST
    along = sum(v * a for v, a in zip(velocity, acceleration, strict=True))
    return Motion(speed_mps, along / speed_mps)


def run_out(position: Ned, velocity: Ned, acceleration: Ned, limits: SpeedLimits) -> Ned:
    """The point straight ahead where a moving vehicle can come to rest, with a little to spare.

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


@dataclass(frozen=True, slots=True)
class _Evenly:
    """A profile of constant speed, with the interface of Ruckig's."""

    speed_mps: float
    duration: float

    def at_time(self, t_s: float) -> tuple[list[float], list[float], list[float]]:
        return [self.speed_mps * t_s], [self.speed_mps], [0.0]


def _flown(
    route: Route, limits: SpeedLimits, start: Motion
) -> tuple[Path, list[ruckig.Trajectory | _Evenly]]:
    """The path of a route, and the profile with which each of its pieces is flown.

    If a start is too fast for the first corner, that is not rounded: a stop there takes less room.
    """
    path = Path(route)
    each, motions = _motions(path, limits, start)
    if len(motions) > 2 and motions[1] == REST and isinstance(path.pieces[1], Turn):
        path = Path(route, keeps_first_turn=False)
        each, motions = _motions(path, limits, start)
    profiles: list[ruckig.Trajectory | _Evenly] = []
    leg = -1
    for piece in path.pieces:
        speed_mps = motions[leg + 1].speed_mps
        if isinstance(piece, StraightLeg):
            leg += 1
            end_mps = motions[leg + 1].speed_mps
            profiles.append(quickest(piece.length_m, motions[leg], end_mps, each[leg]))
        else:
            profiles.append(_Evenly(speed_mps, piece.length_m / speed_mps))
    return path, profiles


def _motions(
    path: Path, limits: SpeedLimits, start: Motion
) -> tuple[list[SpeedLimits], list[Motion]]:
    """The limits along each leg, and the motion at the beginning of each leg and at the end."""
    legs = [piece for piece in path.pieces if isinstance(piece, StraightLeg)]
    each = [limits.along(leg.direction[2]) for leg in legs]
    corners_mps = [
        here.blend.speed_mps(limits) if isinstance(here, Turn) else 0.0
        for here, behind in pairwise(path.pieces)
        if isinstance(behind, StraightLeg)
    ]
    return each, _corner_motions([leg.length_m for leg in legs], corners_mps, start, each)


def _corner_motions(
    lengths_m: list[float], corners_mps: list[float], start: Motion, limits: list[SpeedLimits]
) -> list[Motion]:
    """The motion at the beginning of each leg and at the end of the last, which is at rest.

    Args:
        lengths_m: of the legs, without the blends at their ends.
        corners_mps: greatest speeds at the corners between them.
        start: the motion at the start; reduced to what the first leg allows.
        limits: along each leg.
    """
    if not lengths_m:
        return [REST]
    first, max_mps = limits[0], [*corners_mps, 0.0]
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
    """The greatest speeds at the ends of legs from which the neighbouring ones can be reached."""
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
    """Whether a start on the first leg leaves room to slow down to the speed at its end."""
    released_mps, _ = limits.released(start)
    if end_mps >= released_mps:
        return True
    speed_mps, ahead_m = limits.braking(start)
    return ahead_m + limits.change_m(speed_mps, end_mps) <= room_m


def _courses(
    pieces: Sequence[StraightLeg | Turn], begins_s: list[float]
) -> list[tuple[float, float]]:
    """For each piece that is not too steep: its beginning time, and its course."""
    courses = []
    for piece, begin_s in zip(pieces, begins_s, strict=True):
        north, east, _ = piece.direction
        if math.hypot(north, east) >= _MIN_LEVEL_SHARE:
            courses.append((begin_s, math.atan2(east, north)))
    return courses
