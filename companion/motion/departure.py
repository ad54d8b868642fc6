"""How a flight to a place begins, from rest or from motion: what is flown, and what plans reckon.

A vehicle whose flight is given up comes to rest along its path. The next flight begins on the way
there, at its speed: first to where the vehicle can stop straight ahead, and on from there without
a stop. In a turn it waits until it flies straight on; without such a route it waits for the rest.

Left out: ways that are not known yet, for which a vehicle waits in flight, and how it follows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from companion.geometry import Ned
from companion.motion.layered_routes import LayeredRoutes
from companion.motion.profile import SpeedLimits
from companion.motion.routes import Route
from companion.motion.trajectory import AT_REST, Sample, Stop, Trajectory, motion_of, run_out

SLOW_MPS = 0.2
"""A vehicle slower than this begins a route as if it were at rest."""
UNFORESEEN_SHARE, TURNING_SHARE = 0.85, 0.5
"""Of the acceleration: with what a new plan begins at speed, or a stop that no obstacle asks for;
and such a stop in a turn, which takes acceleration too."""
STRAIGHT_MPS2 = 0.5
"""A vehicle with less acceleration across its path may begin a route that leads straight on."""


@dataclass(frozen=True, slots=True)
class Departure:
    """What a vehicle is told to do when its next flight begins.

    Attributes:
        now: where, and how it moves.
        stop: by which it comes to rest; None if it is under no stop.
        stopping_s: the time of the stop.
    """

    now: Sample
    stop: Stop | None = None
    stopping_s: float = 0.0

    @property
    def is_turning(self) -> bool:
        """Whether it stops in a turn, where no route begins."""
        return self.stop is not None and _across_mps2(self.now) > STRAIGHT_MPS2

    @property
    def rest(self) -> tuple[Ned, float]:
        """Where the vehicle rests unless something else is flown, and the time until then."""
        if self.stop is None:
            return self.now.position, 0.0
        left_s = max(0.0, self.stop.duration_s - self.stopping_s)
        return self.stop.sample(self.stop.duration_s).position, left_s

    def later(self, passed_s: float) -> Departure:
        """The same after more of the stop."""
        assert self.stop is not None
        t_s = self.stopping_s + passed_s
        return Departure(self.stop.sample(t_s), self.stop, t_s)


def at_rest(position: Ned) -> Departure:
    """A departure of a vehicle that hovers."""
    return Departure(Sample(position, AT_REST, AT_REST, is_finished=False))


def is_slow(now: Sample) -> bool:
    """Whether a route begins there as if the vehicle were at rest."""
    return math.hypot(*now.velocity) <= SLOW_MPS


def gentle(limits: SpeedLimits, now: Sample) -> SpeedLimits:
    """The limits of a change of plan at speed; no acceleration of it was told early."""
    share = TURNING_SHARE if _across_mps2(now) > STRAIGHT_MPS2 else UNFORESEEN_SHARE
    return replace(
        limits,
        acceleration_mps2=share * limits.acceleration_mps2,
        jerk_mps3=limits.jerk_mps3 / 2,
    )


def stopping_point(now: Sample, limits: SpeedLimits) -> Ned:
    """Where a route from a motion leads first: the vehicle can come to rest there."""
    return run_out(now.position, now.velocity, now.acceleration, limits)


def from_motion(
    routes: LayeredRoutes, now: Sample, place: str, limits: SpeedLimits
) -> Trajectory | None:
    """A trajectory that begins at some speed; None if no route leads straight on.

    Nor is there one for a vehicle that brakes so hard that it rests before it can do anything else.
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
    """A trajectory that goes on from a motion; None, and so a hold, if there is none."""
    try:
        return Trajectory(route, limits, motion_of(now.velocity, now.acceleration))
    except ArithmeticError:
        return None


def _across_mps2(now: Sample) -> float:
    """The part of the acceleration that turns the velocity."""
    along_mps2 = motion_of(now.velocity, now.acceleration).acceleration_mps2
    return math.sqrt(max(0.0, math.hypot(*now.acceleration) ** 2 - along_mps2**2))
