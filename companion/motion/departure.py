"""How a flight to a place begins, from rest or in motion: for flying, and for planning.

1. A vehicle whose flight is given up comes to rest along its path.
2. The next flight begins while it still moves: first straight ahead to where the vehicle can stop,
   and on from there without a stop.
3. In a turn, it waits until it flies straight. Without such a route, it waits until it rests.

Left out: waiting in flight for routes that are not known yet, and how the vehicle follows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from companion.geometry import Ned
from companion.motion.layered_routes import LayeredRoutes
from companion.motion.profile import Motion, SpeedLimits
from companion.motion.routes import Route
from companion.motion.trajectory import AT_REST, Sample, Stop, Trajectory, motion_of, run_out

SLOW_MPS = 0.2
"""A vehicle slower than this begins a route as if it were at rest."""
UNFORESEEN_SHARE, TURNING_SHARE = 0.85, 0.5
"""Share of the acceleration that is used when a new plan begins at speed, or for a stop that no
obstacle requires; and for such a stop in a turn, which itself takes acceleration."""
STRAIGHT_MPS2 = 0.5
"""A vehicle with less lateral acceleration may begin a route that leads straight on."""


@dataclass(frozen=True, slots=True)
class Departure:
    """How the vehicle moves, by its setpoints, when its next flight begins.

    Attributes:
        now: its position and motion.
        stop: the stop that brings it to rest; None if it is not stopping.
        stopping_s: the time since the stop began.
    """

    now: Sample
    stop: Stop | None = None
    stopping_s: float = 0.0

    @property
    def is_turning(self) -> bool:
        """Whether the vehicle is stopping in a turn, where no route can begin."""
        return self.stop is not None and _across_mps2(self.now) > STRAIGHT_MPS2

    @property
    def rest(self) -> tuple[Ned, float]:
        """Where the vehicle comes to rest if no other flight begins, and the time until then."""
        if self.stop is None:
            return self.now.position, 0.0
        left_s = max(0.0, self.stop.duration_s - self.stopping_s)
        return self.stop.sample(self.stop.duration_s).position, left_s

    def later(self, passed_s: float) -> Departure:
        """The departure after some more time of the stop."""
        assert self.stop is not None
        t_s = self.stopping_s + passed_s
        return Departure(self.stop.sample(t_s), self.stop, t_s)


def at_rest(position: Ned) -> Departure:
    """The departure of a vehicle that hovers."""
    return Departure(Sample(position, AT_REST, AT_REST, is_finished=False))


def is_slow(now: Sample) -> bool:
    """Whether a route begins here as if the vehicle were at rest."""
    return math.hypot(*now.velocity) <= SLOW_MPS


def gentle(limits: SpeedLimits, now: Sample) -> SpeedLimits:
    """The limits for a change of plan at speed, of which the autopilot was not told in advance."""
    share = TURNING_SHARE if _across_mps2(now) > STRAIGHT_MPS2 else UNFORESEEN_SHARE
    return replace(
        limits,
        acceleration_mps2=share * limits.acceleration_mps2,
        jerk_mps3=_gentle_jerk_mps3(limits, motion_of(now.velocity, now.acceleration)),
    )


def _gentle_jerk_mps3(limits: SpeedLimits, motion: Motion) -> float:
    """Half of the greatest jerk, or what it takes to end an acceleration at the speed limit."""
    half_mps3, room_mps = limits.jerk_mps3 / 2, limits.speed_mps - motion.speed_mps
    if motion.acceleration_mps2 <= 0.0:
        return half_mps3
    if room_mps <= 0.0:
        return limits.jerk_mps3
    ending_mps3 = motion.acceleration_mps2**2 / (2 * room_mps)
    return min(max(half_mps3, ending_mps3), limits.jerk_mps3)


def stopping_point(now: Sample, limits: SpeedLimits) -> Ned:
    """Where a route from a motion leads first: a point at which the vehicle can come to rest."""
    return run_out(now.position, now.velocity, now.acceleration, limits)


def from_motion(
    routes: LayeredRoutes, now: Sample, place: str, limits: SpeedLimits
) -> Trajectory | None:
    """A trajectory that begins at some speed; None if no route leads straight on.

    It is also None if the vehicle brakes so hard that it would rest before it can do anything else.
    """
    if limits.released(motion_of(now.velocity, now.acceleration))[0] <= 0.0:
        return None
    stop = stopping_point(now, limits)
    route = routes.route_from_motion(now.position, stop, place)
    return _along(route, limits, now) if route else None


def from_rest(
    routes: LayeredRoutes, start: Ned, place: str, limits: SpeedLimits
) -> Trajectory | None:
    """A trajectory from rest; None if no clear route leads to the place."""
    route = routes.route(start, place)
    return _along(route, limits, at_rest(start).now) if route else None


def _along(route: Route, limits: SpeedLimits, now: Sample) -> Trajectory | None:
    """A trajectory that continues from a motion; None, which means a hold, if there is none."""
    try:
        return Trajectory(route, limits, motion_of(now.velocity, now.acceleration))
    except ArithmeticError:
        return None


def _across_mps2(now: Sample) -> float:
    """The lateral part of the acceleration, which turns the velocity."""
    along_mps2 = motion_of(now.velocity, now.acceleration).acceleration_mps2
    return math.sqrt(max(0.0, math.hypot(*now.acceleration) ** 2 - along_mps2**2))
