"""The leaf that flies: move_cmd of Fig. 6, along a route that keeps clear of what is seen."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from py_trees.common import Status

from companion.acting.behaviour_tree.flight_heading import FlightHeading
from companion.acting.behaviour_tree.leaf import Leaf
from companion.acting.flight import Flight
from companion.acting.guidance import LAG_SHARE
from companion.flight_events.skills import RouteBlocked, RouteResponse
from companion.flight_events.tree import LeafType
from companion.geometry import Ned, NorthEast, distance
from companion.motion.departure import (
    SLOW_MPS,
    from_motion,
    from_rest,
    gentle,
    is_slow,
    stopping_point,
)
from companion.motion.profile import SpeedLimits
from companion.motion.routes import CELLS_PER_TICK
from companion.motion.time_scaling import along, behind_m, time_rate
from companion.motion.trajectory import Sample, Stop, Trajectory, motion_of
from companion.tick import TICK_S
from companion.vehicle.ports.state import VehicleState

ARRIVAL_M = 0.3
"""How near the vehicle has to come to a place in order to be there."""
ARRIVAL_SIGMAS = 2.0
"""The same in standard deviations of the position, if that is more: a hovering vehicle wanders by
about one of them. It is limited by the place's own radius."""
ARRIVAL_MPS = 0.5
"""A faster vehicle still swings past the place, towards what stands behind it."""
ARRIVAL_TIMEOUT_S = 15.0
"""Time after the end of the trajectory to come that near: to catch up, or, if the vehicle is pushed
off its path again and again, to come nearer to the place."""
ASTRAY_SHARE = 14 / 15
"""Share of the gate's greatest distance: if a resting vehicle is so far off, it gets a new route.
The gate would soon hold it there, away from a trajectory that waits for it."""


@dataclass(frozen=True, slots=True)
class AwaitedRoute:
    """The vehicle holds, or comes to rest along an earlier path, until its route can begin.

    Attributes:
        is_turning: when it began to wait, the path along which it comes to rest led round a corner.
    """

    is_turning: bool


class MoveCommand(Leaf):
    """move_cmd(c, w): flies a clear route to a place.

    1. The flight begins at the setpoint that the vehicle follows, at its speed, so no setpoint
       jumps.
    2. The trajectory is slowed for a vehicle that falls behind, and waits for it, so that its
       setpoint never runs away; otherwise the gate would hold the vehicle. It is also slowed to the
       speed limit in force.
    3. A fast vehicle that cannot stop straight ahead on a clear leg comes to rest along the path
       that it flew, and begins there. So does the vehicle of an interrupted flight.
    4. When the map has changed, the rest of the trajectory is checked again. If it is no longer
       clear, these are tried in order: another route, entered without a stop; a stop straight
       ahead, and a route from there; failure, because no clear route is left.

    Attributes:
        failed_at: number of positions of the word when it last failed; None if it never has.

    Args:
        flight: what it acts on.
        place: where it flies to.
        timeout_s: longest time; None for no limit.
        look_at: point that the vehicle looks at; None to look in the direction of flight.
    """

    does = LeafType.MOVE_CMD

    def __init__(
        self,
        flight: Flight,
        place: str,
        timeout_s: float | None,
        look_at: NorthEast | None = None,
    ) -> None:
        super().__init__(flight, f"move_cmd {place}")
        self.failed_at: int | None = None
        self._place = place
        self._timeout_s = timeout_s
        self._heading = FlightHeading(flight, place, look_at)

    def initialise(self) -> None:
        """Finds the route from where the vehicle is now, at its present speed."""
        state = self._flight.vehicle.state
        self._flown: Trajectory | Stop | AwaitedRoute | None = None  # None without a route
        self._flight.progress.flight_ends_s = None
        self._updated_s: float | None = None
        if state is not None:
            self._begin(state)
        self._start_s = self._nearer_s = self._flight.now_s
        self._least_left_m = math.inf

    def _begin(self, state: VehicleState) -> None:
        """Begins a new route; if there is none at this speed, a stop that is under way continues.

        While routes are being searched, the vehicle holds.
        """
        departure = self._flight.guidance.departure_of(state)
        now, is_turning = departure.now, departure.is_turning
        limits = gentle(self._flight.speed_limit.for_trajectory, now)
        self._time_s = 0.0
        self._flown = None
        if not is_turning and self._knows_ways_of(now, limits):
            self._flown = self._from_motion(now, limits)
        if self._flown is None and departure.stop is None and self._knows_ways(now.position):
            self._flown = self._from_rest(now.position)
            self._time_s = -TICK_S  # its acceleration is sent early, so it grows more gently
        elif self._flown is None:
            self._flown = AwaitedRoute(is_turning)
        self._flown_s, self._rate = self._time_s, 1.0
        self._told: RouteBlocked | None = None
        self._map_version = self._flight.routes.version
        self._updated_s = None
        self._in_time_s = self._flight.now_s

    def _wait(self, awaited: AwaitedRoute, state: VehicleState) -> None:
        """Begins when a stop has ended, or when it leads straight on."""
        is_straight = (
            awaited.is_turning and not self._flight.guidance.departure_of(state).is_turning
        )
        if self._flight.guidance.stop is None or is_straight:
            self._begin(state)

    def _knows_ways(self, start: Ned) -> bool:
        """Whether a route from there needs no further search; if it does, searches for a tick."""
        return self._flight.routes.search(start, self._place, CELLS_PER_TICK)

    def _knows_ways_of(self, now: Sample, limits: SpeedLimits) -> bool:
        """The same for a route that begins at some speed; a slow vehicle has none."""
        return is_slow(now) or self._knows_ways(stopping_point(now, limits))

    def _from_motion(self, now: Sample, limits: SpeedLimits) -> Trajectory | None:
        """A trajectory that begins at some speed, over known routes; None if there is none."""
        if is_slow(now):
            return None
        return from_motion(self._flight.routes, now, self._place, limits)

    def _from_rest(self, start: Ned) -> Trajectory | None:
        """A trajectory from rest; None if no clear route leads to the place."""
        limits = self._flight.speed_limit.for_trajectory
        return from_rest(self._flight.routes, start, self._place, limits)

    def update(self) -> Status:
        """Sends one setpoint along the trajectory; SUCCESS at the place."""
        flight, state = self._flight, self._flight.vehicle.state
        if state is not None and isinstance(self._flown, AwaitedRoute):
            self._wait(self._flown, state)
            if isinstance(self._flown, AwaitedRoute):
                flight.guidance.hold()
                return Status.RUNNING
        self._advance()
        if state is not None:
            self._follow_map(state)
        if state is None or not isinstance(self._flown, Trajectory | Stop):
            return self._stop_and_fail(f"no clear route to {self._place}")
        elapsed_s = flight.now_s - self._start_s
        if self._timeout_s is not None and elapsed_s > self._timeout_s:
            return self._stop_and_fail(f"not there after {self._timeout_s:.0f} s")
        self._flown_s = self._time_s
        flight.progress.flight_ends_s = flight.now_s + self._flown.duration_s - self._time_s
        sample = self._sample(self._flown)
        gap_m = distance(flight.guidance.sent(sample.position), state.motion.position)
        is_astray = gap_m >= ASTRAY_SHARE * flight.profile.carrot_m
        if is_astray and math.hypot(*state.motion.velocity) <= SLOW_MPS:
            self._begin(state)
            return self._stop_and_fail(self._stuck) if self._gets_nowhere() else Status.RUNNING
        sample, is_behind = self._followed(sample, state)
        is_at_end = sample.is_finished and isinstance(self._flown, Trajectory)
        flight.guidance.fly(sample, self._heading.wanted(sample, state, is_at_end))
        if is_at_end and self._is_there(gap_m, state) and self._heading.is_reached(state):
            return Status.SUCCESS
        if self._time_s > self._flown.duration_s + ARRIVAL_TIMEOUT_S + self._heading.turn_s:
            return self._stop_and_fail(self._why_not_there(gap_m, state))
        self._updated_s = flight.now_s
        self._in_time_s = self._in_time_s if is_behind else flight.now_s
        if flight.now_s - self._in_time_s > ARRIVAL_TIMEOUT_S:
            return self._stop_and_fail(self._stuck)
        return Status.RUNNING

    @property
    def _stuck(self) -> str:
        return f"stuck on the way to {self._place}"

    def _gets_nowhere(self) -> bool:
        """Whether a vehicle that begins again, off its path, has come no nearer for too long."""
        if not isinstance(self._flown, Trajectory):
            return False
        left_m = self._flown.path.length_m
        if left_m < self._least_left_m - ARRIVAL_M:
            self._least_left_m, self._nearer_s = left_m, self._flight.now_s
        return self._flight.now_s - self._nearer_s > ARRIVAL_TIMEOUT_S

    def terminate(self, new_status: Status) -> None:
        """Holds where the vehicle is when something above interrupts; notes a failure."""
        if new_status is Status.FAILURE:
            self.failed_at = self._flight.task.word.positions
        if new_status is Status.INVALID and self.status is Status.RUNNING:
            self._brake()

    def _advance(self) -> None:
        """Advances the trajectory's time from one update to the next."""
        if self._updated_s is not None:
            self._time_s += self._rate * self._flight.elapsed_s(self._updated_s)

    def _sample(self, flown: Trajectory | Stop) -> Sample:
        """The moment of the trajectory that may be flown now; sets how fast its time runs."""
        led = self._flight.guidance.led(flown, self._time_s)
        slowed, self._rate = self._flight.speed_limit.slowed(led)
        return slowed

    def _followed(self, sample: Sample, state: VehicleState) -> tuple[Sample, bool]:
        """The sample, slowed for a vehicle that is behind; and whether it is far behind."""
        away = self._flight.guidance.away(state, sample.position)
        behind_share = behind_m(away, sample.velocity) / self._flight.profile.carrot_m
        vehicle_mps = along(state.motion.velocity, sample.velocity)
        rate = time_rate(behind_share, math.hypot(*sample.velocity), vehicle_mps)
        self._rate *= rate
        return sample.slower(rate), behind_share >= LAG_SHARE

    def _is_there(self, gap_m: float, state: VehicleState) -> bool:
        """Whether the vehicle is at the place, as far as its position can tell, and slow."""
        wander_m = ARRIVAL_SIGMAS * state.motion.accuracy_m
        near_m = max(ARRIVAL_M, min(wander_m, self._flight.symbols.inner_m(self._place)))
        return gap_m < near_m and math.hypot(*state.motion.velocity) < ARRIVAL_MPS

    def _why_not_there(self, gap_m: float, state: VehicleState) -> str:
        if not self._is_there(gap_m, state):
            return f"still {gap_m:.1f} m from {self._place}"
        return f"at {self._place}, but {self._heading.error_deg(state)} degrees off the heading"

    def _brake(self) -> None:
        """Brakes along the path, from the last setpoint."""
        flight, flown = self._flight, self._flown
        if isinstance(flown, Stop):
            flight.guidance.stop_along(flown, self._flown_s)
        elif not isinstance(flown, Trajectory) or flight.guidance.setpoint is None:
            flight.guidance.hold()
        else:
            now = flown.sample(self._flown_s).slower(self._rate)
            limits = gentle(flight.speed_limit.for_trajectory, now)
            stop = _stop(flown, self._flown_s, now, limits)
            flight.guidance.stop_along(stop, 0.0) if stop else flight.guidance.hold()

    def _follow_map(self, state: VehicleState) -> None:
        """Leaves a trajectory that is no longer clear, and continues from a stop."""
        routes, flown = self._flight.routes, self._flown
        if isinstance(flown, Stop):
            has_stopped = math.hypot(*state.motion.velocity) <= SLOW_MPS
            told = self._flight.guidance.departure_of(state).now.position
            has_stopped = has_stopped and flown.sample(self._time_s).is_finished
            if has_stopped and self._knows_ways(told):
                self._adopt(self._from_rest(told))
        elif isinstance(flown, Trajectory) and self._map_version != routes.version:
            if routes.is_clear(flown.ahead(self._time_s)):
                self._map_version = routes.version
            else:
                self._avoid(flown)

    def _avoid(self, trajectory: Trajectory) -> None:
        """Begins another route without a stop, or a stop along the path.

        While routes are being searched, the trajectory is flown on as long as clear room to stop
        remains.
        """
        now = trajectory.sample(self._time_s).slower(self._rate)
        limits = self._flight.speed_limit.for_trajectory
        is_known = self._knows_ways_of(now, limits)
        if is_known and (around := self._from_motion(now, limits)) is not None:
            self._adopt(around)
            return
        braking = replace(limits, acceleration_mps2=self._flight.profile.braking_mps2)
        stop = _stop(trajectory, self._time_s, now, braking)
        if stop is not None and not is_known:
            room = trajectory.between(self._time_s, self._time_s + stop.duration_s + 2 * TICK_S)
            if self._flight.routes.is_clear(room):
                return
        self._adopt(stop)

    def _adopt(self, flown: Trajectory | Stop | None) -> None:
        self._flown = flown
        self._map_version = self._flight.routes.version
        self._time_s, self._rate = 0.0, 1.0
        blocked = RouteBlocked(self._place, _RESPONSES[type(flown)])
        if blocked != self._told:
            self._flight.report(blocked)
        self._told = blocked

    def _stop_and_fail(self, why: str) -> Status:
        self._brake()
        return self.fail(why)


_RESPONSES = {
    Trajectory: RouteResponse.ANOTHER_ROUTE,
    Stop: RouteResponse.STOPPING,
    type(None): RouteResponse.NO_ROUTE,
}


def _stop(trajectory: Trajectory, t_s: float, now: Sample, limits: SpeedLimits) -> Stop | None:
    """A stop along the path of a trajectory, from the present motion; None if there is none."""
    try:
        return Stop(trajectory, t_s, motion_of(now.velocity, now.acceleration), limits)
    except ArithmeticError:
        return None
