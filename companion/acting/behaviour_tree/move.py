"""The leaf that flies: move_cmd of Fig. 6, along a route that stays clear of what is seen."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from py_trees.common import Status

from companion.acting.behaviour_tree.leaf import Leaf
from companion.acting.flight import TICK_S, Flight
from companion.flight_events.skills import RouteBlocked, RouteResponse
from companion.flight_events.tree import LeafType
from companion.geometry import distance
from companion.motion.profile import SpeedLimits
from companion.motion.routes import Route
from companion.motion.trajectory import AT_REST, Sample, Trajectory, motion_of, run_out
from companion.vehicle.port import Setpoint, VehicleState, hold_at

ARRIVAL_M = 0.3
"""How near to a place the vehicle has to come to be there."""
ARRIVAL_TIMEOUT_S = 15.0
"""How long it may take to come that near after the trajectory has ended, or to catch up."""
SLOW_MPS = 0.2
"""A vehicle slower than this begins a route as if it were at rest."""
LAG_SHARE = 0.6
"""Of the gate's carrot: distance behind the trajectory at which the trajectory waits."""
ASTRAY_SHARE = 14 / 15
"""Of the gate's carrot: distance at which a vehicle that has come to rest takes a new way; the gate
would soon hold it there, away from a trajectory that waits for it."""


class MoveCommand(Leaf):
    """move_cmd(c, w): flies a clear route to a place.

    The trajectory waits for a vehicle that has fallen behind, so that its setpoint never runs
    away; the gate would hold it otherwise. It is slowed to the speed limit in force. A fast vehicle
    that cannot stop straight ahead on a clear leg leaves its new route while it brakes; it begins
    again from where it has come to rest.

    When the map has changed, what is left of the trajectory is looked at again. If it is no
    longer clear there are, in this order: another route, flown into without a stop; a stop
    straight ahead, and a route from there; failure, since no clear route is left.

    Attributes:
        failed_at: how many positions the word had when it failed last; None if it never has.
    """

    does = LeafType.MOVE_CMD

    def __init__(self, flight: Flight, place: str, timeout_s: float | None) -> None:
        super().__init__(flight, f"move_cmd {place}")
        self.failed_at: int | None = None
        self._place = place
        self._timeout_s = timeout_s

    def initialise(self) -> None:
        """Finds the route from where the vehicle is, and how fast, now."""
        state = self._flight.vehicle.state
        self._trajectory: Trajectory | None = None
        if state is not None:
            self._begin(state)
        self._start_s = self._flight.now_s

    def _begin(self, state: VehicleState) -> None:
        seen = Sample(state.position, state.velocity, AT_REST, state.yaw_rad, False)
        self._trajectory = self._from_motion(seen) or self._from_rest(state)
        self._told: RouteBlocked | None = None
        self._is_braking = False
        self._map_version = self._flight.routes.version
        self._time_s = 0.0
        self._waited_s = 0.0

    def _from_motion(self, now: Sample) -> Trajectory | None:
        """A trajectory that begins at some speed; None if there is none, or hardly any speed."""
        if math.hypot(*now.velocity) <= SLOW_MPS:
            return None
        limits = self._flight.speed_limit.for_trajectory
        stop = run_out(now.position, now.velocity, now.acceleration, limits)
        route = self._flight.routes.route_from_motion(now.position, stop, self._place)
        return _along(route, limits, now) if route else None

    def _from_rest(self, state: VehicleState) -> Trajectory | None:
        """A trajectory from rest; None if no clear route leads to the place."""
        route = self._flight.routes.route(state.position, self._place)
        still = Sample(state.position, AT_REST, AT_REST, state.yaw_rad, False)
        return _along(route, self._flight.speed_limit.for_trajectory, still) if route else None

    def update(self) -> Status:
        """One setpoint along the trajectory; SUCCESS at the place."""
        flight, state = self._flight, self._flight.vehicle.state
        if state is not None:
            self._follow_map(state)
        if self._trajectory is None or state is None:
            return self._hold_and_fail(f"no clear route to {self._place}")
        elapsed_s = flight.now_s - self._start_s
        if self._timeout_s is not None and elapsed_s > self._timeout_s:
            return self._hold_and_fail(f"not there after {self._timeout_s:.0f} s")
        sample, rate = flight.speed_limit.slowed(self._trajectory.sample(self._time_s))
        gap_m = distance(sample.position, state.position)
        is_behind = gap_m >= LAG_SHARE * flight.profile.carrot_m
        is_astray = gap_m >= ASTRAY_SHARE * flight.profile.carrot_m
        if is_astray and math.hypot(*state.velocity) <= SLOW_MPS:
            self._begin(state)
            return Status.RUNNING
        flight.fly(
            hold_at(sample.position, sample.yaw_rad)
            if is_behind
            else Setpoint(sample.position, sample.velocity, sample.acceleration, sample.yaw_rad)
        )
        if sample.is_finished and gap_m < ARRIVAL_M and not self._is_braking:
            return Status.SUCCESS
        if self._time_s > self._trajectory.duration_s + ARRIVAL_TIMEOUT_S:
            return self._hold_and_fail(f"still {gap_m:.1f} m from {self._place}")
        self._time_s += 0.0 if is_behind else rate * TICK_S
        self._waited_s = self._waited_s + TICK_S if is_behind else 0.0
        if self._waited_s > ARRIVAL_TIMEOUT_S:
            return self._hold_and_fail(f"stuck on the way to {self._place}")
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Stays where it is when something above interrupts; notes a failure."""
        if new_status is Status.FAILURE:
            self.failed_at = self._flight.task.positions
        if new_status is Status.INVALID and self.status is Status.RUNNING:
            self._flight.hold()

    def _follow_map(self, state: VehicleState) -> None:
        """Leaves a trajectory that is no longer clear, and goes on from a stop."""
        routes, trajectory = self._flight.routes, self._trajectory
        if trajectory is None:
            return
        if self._is_braking:
            has_stopped = math.hypot(*state.velocity) <= SLOW_MPS
            if has_stopped and trajectory.sample(self._time_s).is_finished:
                self._adopt(self._from_rest(state), is_braking=False)
        elif self._map_version != routes.version:
            self._map_version = routes.version
            if not routes.is_clear(trajectory.ahead(self._time_s)):
                self._avoid(trajectory.sample(self._time_s))

    def _avoid(self, now: Sample) -> None:
        """Another route without a stop, or a stop."""
        around = self._from_motion(now)
        if around is not None:
            self._adopt(around, is_braking=False)
            return
        braking = replace(
            self._flight.speed_limit.for_trajectory,
            acceleration_mps2=self._flight.profile.braking_mps2,
        )
        stop = run_out(now.position, now.velocity, now.acceleration, braking)
        straight = Route(np.array([now.position, stop]))
        self._adopt(_along(straight, braking, now), is_braking=True)

    def _adopt(self, trajectory: Trajectory | None, is_braking: bool) -> None:
        self._trajectory, self._is_braking = trajectory, is_braking
        self._map_version = self._flight.routes.version
        self._time_s = 0.0
        response = RouteResponse.STOPPING if is_braking else RouteResponse.ANOTHER_ROUTE
        blocked = RouteBlocked(self._place, response if trajectory else RouteResponse.NO_ROUTE)
        if blocked != self._told:
            self._flight.report(blocked)
        self._told = blocked

    def _hold_and_fail(self, why: str) -> Status:
        self._flight.hold()
        return self.fail(why)


def _along(route: Route, limits: SpeedLimits, now: Sample) -> Trajectory | None:
    """A trajectory that goes on from a motion; None, and so a hold, if there is none."""
    try:
        return Trajectory(route, limits, now.yaw_rad, motion_of(now.velocity, now.acceleration))
    except ArithmeticError:
        return None
