"""The leaves of the tree (Figs. 5 and 6): conditions, effects, and the primitives that fly.

`initialise` runs when a leaf is entered, `update` once per tick, `terminate` when it is left;
with status INVALID if something above has interrupted it. Time comes from the flight, never
from a clock.
"""

from __future__ import annotations

import math

import numpy as np
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from companion.acting.flight import TICK_S, Flight
from companion.geometry import Ned, distance
from companion.mission.model import Command
from companion.motion.routes import Route
from companion.motion.trajectory import Sample, Trajectory, run_out
from companion.planning.domain import Action, Fact
from companion.vehicle.port import Progress, Setpoint, VehicleState, hold_at

ACCELERATION_MPS2 = 2.0
ARRIVAL_M = 0.3
"""How near to a place the vehicle has to come to be there."""
ARRIVAL_TIMEOUT_S = 15.0
"""How long it may take to come that near after the trajectory has ended, or to catch up."""
SLOW_MPS = 0.2
"""A vehicle slower than this begins a route as if it were at rest."""
LAG_M = 0.9
"""Distance behind the trajectory at which the trajectory waits; below the gate's carrot."""
ASTRAY_M = 1.4
"""Distance at which a vehicle that has come to rest takes a new way; the gate would soon hold it
there, away from a trajectory that waits for it."""


class AsPredicted(Behaviour):
    """Leftmost branch: do the events that matter to the plan still have their values?"""

    def __init__(self, flight: Flight, predicted: dict[Fact, bool]) -> None:
        super().__init__("as predicted?")
        self._flight = flight
        self._predicted = predicted

    def update(self) -> Status:
        """FAILURE on the first difference, which replans."""
        if self._flight.is_grounded:
            return Status.SUCCESS  # what was begun on the ground is finished first
        facts = self._flight.task.facts
        wrong = [f for f, holds in self._predicted.items() if (f in facts) != holds]
        self.feedback_message = ", ".join(wrong)
        return Status.FAILURE if wrong else Status.SUCCESS


class Precondition(Behaviour):
    """Green block: does the precondition hold? If so the present position is left.

    Before it, nothing of the action has begun: the moment for a better plan, if there may be one.
    """

    def __init__(self, flight: Flight, action: Action) -> None:
        super().__init__(f"pre {action.name}")
        self._flight = flight
        self._action = action

    def update(self) -> Status:
        """FAILURE if a fact is missing."""
        task = self._flight.task
        if self._flight.may_do_better:
            return Status.FAILURE
        if not self._action.is_applicable(task.all_facts):
            missing = sorted(self._action.requires - task.all_facts)
            wanting = ", ".join(missing) or "a forbidden fact"
            self._flight.failure = f"{self._action.name} cannot begin: {wanting}"
            return Status.FAILURE
        task.begin(self._action)
        return Status.SUCCESS


class Effects(Behaviour):
    """Blue block: takes the effects over into the task's state.

    Args:
        ends_lap: whether the action is the last one of the loop.
    """

    def __init__(self, flight: Flight, action: Action, ends_lap: bool) -> None:
        super().__init__(f"eff {action.name}")
        self._flight = flight
        self._action = action
        self._ends_lap = ends_lap

    def update(self) -> Status:
        """Always SUCCESS."""
        flight, action = self._flight, self._action
        flight.task.complete(action)
        if action.destination is not None and len(action.execute) == 1:
            flight.report("at", f"at {action.destination}", action=action.name)
        elif action.assumes or action.adds:
            flight.report("done", f"{action.name} done", action=action.name)
        flight.failure = ""
        flight.completed += 1
        flight.laps += self._ends_lap
        return Status.SUCCESS


class Withdraw(Behaviour):
    """Right branch of Fig. 6: the skill has failed, so what it assumed is not believed.

    A skill that has not begun, because its precondition does not hold, disproves nothing.
    """

    def __init__(self, flight: Flight, action: Action) -> None:
        super().__init__(f"withdraw {', '.join(sorted(action.assumes)) or 'nothing'}")
        self._flight = flight
        self._action = action

    def update(self) -> Status:
        """Always SUCCESS; the inverter above turns it into the FAILURE that replans."""
        flight, action = self._flight, self._action
        if flight.task.running is not action:
            return Status.SUCCESS
        flight.failure = f"{action.name} failed: {flight.failure}"
        flight.report("failed", flight.failure, action=action.name)
        retry_s = None if action.retry_after_s is None else flight.now_s + action.retry_after_s
        flight.task.withdraw(action.assumes, retry_s)
        for belief in sorted(action.assumes):
            flight.report("withdrawn", f"belief {belief} withdrawn", belief=belief)
        return Status.SUCCESS


class UpdateParam(Behaviour):
    """update_param(c, w): grounds the symbol `w` to a waypoint that can be flown to now.

    `c` is always the vehicle's present state, so there is nothing to ground for it.
    """

    def __init__(self, flight: Flight, place: str) -> None:
        super().__init__(f"update_param {place}")
        self._flight = flight
        self._place = place

    def update(self) -> Status:
        """FAILURE if the place is not free on the map as it is known now."""
        flight = self._flight
        if flight.routes.is_free(flight.symbols[self._place][:2]):
            return Status.SUCCESS
        flight.failure = f"{self._place} is not free"
        return Status.FAILURE


class MoveCommand(Behaviour):
    """move_cmd(c, w): flies a clear route to a place.

    The trajectory waits for a vehicle that has fallen behind, so that its setpoint never runs
    away; the gate would hold it otherwise. A fast vehicle that cannot stop straight ahead on a
    clear leg leaves its new route while it brakes; it begins again from where it has come to rest.

    When the map has changed, what is left of the trajectory is looked at again. If it is no
    longer clear there are, in this order: another route, flown into without a stop; a stop
    straight ahead, and a route from there; failure, since no clear route is left.
    """

    def __init__(self, flight: Flight, place: str, timeout_s: float | None) -> None:
        super().__init__(f"move_cmd {place}")
        self._flight = flight
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
        self._trajectory = self._from_motion(
            state.position, state.velocity, state.yaw_rad
        ) or self._from_rest(state)
        self._is_braking = False
        self._map_version = self._flight.routes.version
        self._time_s = 0.0
        self._waited_s = 0.0

    def _from_motion(self, position: Ned, velocity: Ned, yaw_rad: float) -> Trajectory | None:
        """A trajectory that begins at some speed; None if there is none, or hardly any speed."""
        start_mps = math.hypot(*velocity)
        if start_mps <= SLOW_MPS:
            return None
        stop = run_out(position, velocity, ACCELERATION_MPS2)
        route = self._flight.routes.route_from_motion(position, stop, self._place)
        return self._along(route, yaw_rad, start_mps) if route else None

    def _from_rest(self, state: VehicleState) -> Trajectory | None:
        """A trajectory from rest; None if no clear route leads to the place."""
        route = self._flight.routes.route(state.position, self._place)
        return self._along(route, state.yaw_rad, 0.0) if route else None

    def _along(self, route: Route, yaw_rad: float, start_mps: float) -> Trajectory:
        speed_mps = self._flight.limits.speed_mps
        return Trajectory(route, speed_mps, ACCELERATION_MPS2, yaw_rad, start_mps)

    def update(self) -> Status:
        """One setpoint along the trajectory; SUCCESS at the place."""
        flight, state = self._flight, self._flight.vehicle.state
        if state is not None:
            self._follow_map(state)
        if self._trajectory is None or state is None:
            return self._fail(f"no clear route to {self._place}")
        elapsed_s = flight.now_s - self._start_s
        if self._timeout_s is not None and elapsed_s > self._timeout_s:
            return self._fail(f"not there after {self._timeout_s:.0f} s")
        sample = self._trajectory.sample(self._time_s)
        gap_m = distance(sample.position, state.position)
        is_behind = gap_m >= LAG_M
        if gap_m >= ASTRAY_M and math.hypot(*state.velocity) <= SLOW_MPS:
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
            return self._fail(f"still {gap_m:.1f} m from {self._place}")
        self._time_s += 0.0 if is_behind else TICK_S
        self._waited_s = self._waited_s + TICK_S if is_behind else 0.0
        if self._waited_s > ARRIVAL_TIMEOUT_S:
            return self._fail(f"stuck on the way to {self._place}")
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Stays where it is when something above interrupts."""
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
        around = self._from_motion(now.position, now.velocity, now.yaw_rad)
        if around is not None:
            self._adopt(around, is_braking=False)
            return
        stop = run_out(now.position, now.velocity, ACCELERATION_MPS2)
        straight = Route(np.array([now.position, stop]))
        brake = self._along(straight, now.yaw_rad, math.hypot(*now.velocity))
        self._adopt(brake, is_braking=True)

    def _adopt(self, trajectory: Trajectory | None, is_braking: bool) -> None:
        self._trajectory, self._is_braking = trajectory, is_braking
        self._map_version = self._flight.routes.version
        self._time_s = 0.0
        what = "stopping" if is_braking else "another route"
        text = f"the way to {self._place} is not clear: {what if trajectory else 'no route'}"
        self._flight.report("route", text, place=self._place)

    def _fail(self, why: str) -> Status:
        self._flight.failure = why
        self._flight.hold()
        return Status.FAILURE


class SendCommand(Behaviour):
    """Sends a MAVLink command to a component and waits, holding, for its final answer."""

    def __init__(self, flight: Flight, command: Command, timeout_s: float | None) -> None:
        super().__init__(f"command {command.name}")
        self._flight = flight
        self._command = command
        self._timeout_s = timeout_s
        self._ticket: int | None = None

    def initialise(self) -> None:
        """Sends it for the first time."""
        flight, command = self._flight, self._command
        self._start_s = flight.now_s
        self._ticket = flight.vehicle.send_command(
            command.component, command.command, command.parameters
        )

    def update(self) -> Status:
        """SUCCESS if it was accepted."""
        flight = self._flight
        flight.hold()
        assert self._ticket is not None
        outcome = flight.vehicle.command_outcome(self._ticket)
        if outcome.progress is Progress.DONE:
            return Status.SUCCESS
        if outcome.progress is Progress.FAILED:
            flight.failure = outcome.reason
            return Status.FAILURE
        if self._timeout_s is not None and flight.now_s - self._start_s > self._timeout_s:
            flight.failure = f"no final answer in {self._timeout_s:.0f} s"
            return Status.FAILURE
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Stops asking."""
        if self._ticket is not None and new_status is not Status.RUNNING:
            self._flight.vehicle.forget_command(self._ticket)
            self._ticket = None


class Rest(Behaviour):
    """Holds position for a time."""

    def __init__(self, flight: Flight, duration_s: float) -> None:
        super().__init__("rest")
        self._flight = flight
        self._duration_s = duration_s

    def initialise(self) -> None:
        """Starts the time."""
        self._end_s = self._flight.now_s + self._duration_s

    def update(self) -> Status:
        """SUCCESS when the time is over."""
        self._flight.hold()
        return Status.SUCCESS if self._flight.now_s >= self._end_s else Status.RUNNING
