"""Guidance: the setpoints of one flight, from moments of trajectories, stops and holds.

Once a tick, a leaf of the tree or a phase of the sortie says what to fly: a moment of a trajectory,
a step of a descent, or a hold. If the vehicle is too near to a wall or to the ground, the setpoint
is moved away. Then it goes to the vehicle, and there through the gate. The next flight begins at
the setpoint as it was before it was moved.

A flight that is interrupted comes to rest along its path: from then on `brake` streams the stop.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from companion.acting.ground_guard import GroundGuard
from companion.acting.wall_guard import WallGuard
from companion.flight_events.event import FlightEvent
from companion.geometry import Ned, moved, times
from companion.mission.places import Limits
from companion.motion.departure import Departure, at_rest
from companion.motion.drag_estimate import DragEstimate
from companion.motion.heading import turned
from companion.motion.layered_routes import LayeredRoutes
from companion.motion.trajectory import AT_REST, Sample, Stop, Trajectory
from companion.tick import TICK_S
from companion.vehicle.ports.setpoints import Setpoint
from companion.vehicle.ports.state import VehicleState
from companion.vehicle.ports.vehicle import SteeredVehicle
from companion.vehicle_profile import VehicleProfile

HELD_M = 0.5
"""A vehicle that is nearer to its setpoint is held there; otherwise it is held where it is."""
LAG_SHARE = 0.6
"""Share of the gate's greatest distance: a vehicle further behind its setpoint counts as behind."""


class Guidance:
    """Tells the vehicle what to fly.

    Args:
        vehicle: follows the setpoints.
        routes: know the walls, and what is below.
        profile: the profile of the vehicle that the mission is written for.
        limits: the mission's limits.
        now: the time of the tick.
        report: receives events about walls or ground that are too near.

    Attributes:
        is_for_task: whether the plan of the task is flown; `FlownTask` writes it.
        drag: the vehicle's drag, as it is learnt in flight.
    """

    def __init__(
        self,
        vehicle: SteeredVehicle,
        routes: LayeredRoutes,
        profile: VehicleProfile,
        limits: Limits,
        now: Callable[[], float],
        report: Callable[[FlightEvent], None],
    ) -> None:
        self.is_for_task = False
        self.drag = DragEstimate()
        self._vehicle, self._profile, self._limits = vehicle, profile, limits
        self._now, self._report = now, report
        self._setpoint: Setpoint | None = None
        self._is_landing = False
        self._stop: Stop | None = None
        self._stop_begin_s = self._streamed_s = 0.0
        self._walls = WallGuard(routes, profile)
        self._ground = GroundGuard(routes, profile, limits.up_m[1])

    @property
    def setpoint(self) -> Setpoint | None:
        """The setpoint that is streamed, as it was before any move; None if there is none."""
        return self._setpoint

    @property
    def approaches_wall(self) -> bool:
        """Whether the vehicle swings from its setpoint towards a wall."""
        told, state = self._setpoint, self._vehicle.state
        if told is None or state is None:
            return False
        return self._walls.is_approached(told.position, state)

    @property
    def stop(self) -> Stop | None:
        """How the vehicle brakes along the path that it flew before; None if it does not."""
        return self._stop

    @property
    def stopping_s(self) -> float:
        """The time since the stop began."""
        return self._now() - self._stop_begin_s

    @property
    def departure(self) -> Departure | None:
        """How a flight would begin now; None while nothing is known of the vehicle."""
        state = self._vehicle.state
        return None if state is None else self.departure_of(state)

    def departure_of(self, state: VehicleState) -> Departure:
        """How a flight would begin in a state.

        It begins with the motion of the setpoint, if the vehicle follows that, or else with the
        vehicle's own motion. A vehicle above its altitudes comes down to them as it leaves.
        """
        told, stop, t_s = self._setpoint, self._stop, self.stopping_s
        within_m = LAG_SHARE * self._profile.carrot_m
        if told is None or math.hypot(*self.away(state, told.position)) >= within_m:
            here = self._not_above_band(state.motion.position)
            own = Sample(here, state.motion.velocity, AT_REST, is_finished=False)
            return Departure(own, stop, t_s)
        return at_rest(told.position) if stop is None else Departure(stop.sample(t_s), stop, t_s)

    def away(self, state: VehicleState, position: Ned) -> Ned:
        """From the vehicle to a position that is streamed in this tick, or was in the last one.

        The vehicle is not where it was measured: it has flown on since then. It is compared with
        the setpoint where it will be after half a tick, because a setpoint that moves in steps from
        tick to tick is followed in the middle of its steps.
        """
        here = state.motion.position_at(self._now() + TICK_S / 2)
        return moved(self.sent(position), here, -1.0)

    def led(self, flown: Trajectory | Stop, t_s: float) -> Sample:
        """A moment of a trajectory, with the acceleration that makes the vehicle follow it.

        It is the acceleration `response_s` later, because the vehicle responds with that delay,
        times `feed_forward`, because its controller takes a share away; and the drag of the air.
        """
        profile = self._profile
        later = flown.sample(t_s + profile.response_s)
        north, east, _ = times(later.velocity, self.drag.per_s)
        return replace(
            flown.sample(t_s),
            acceleration=times(later.acceleration, profile.feed_forward),
            against_drag=(north, east, 0.0),
        )

    def learn(self, state: VehicleState) -> None:
        """Estimates the drag from the vehicle's motion; once a tick."""
        if state.is_landed:
            self.drag.pause()
        else:
            motion = state.motion
            self.drag.take(motion.boot_s, motion.velocity[:2], state.attitude.thrust_mps2)

    def brake(self) -> None:
        """Streams the next moment of a stop, if there is one; once a tick, before all else."""
        if self._stop is None:
            return
        sample = self.led(self._stop, self.stopping_s)
        self._stream(sample, None)
        if sample.is_finished:
            self._stop = None

    def fly(self, sample: Sample, heading_rad: float | None = None) -> None:
        """Streams a moment of a flight from now on.

        Args:
            sample: where the vehicle has to be, and how it has to move.
            heading_rad: the heading to turn to, as fast as the profile allows; None to keep it.
        """
        self._stop = None
        self._stream(sample, heading_rad, is_for_task=self.is_for_task)

    def descend(self, sample: Sample) -> None:
        """Streams a moment of the way down to a marker, or of the search for it."""
        self._stop = None
        self._stream(sample, None, is_for_task=self.is_for_task, is_landing=True)

    def stop_along(self, stop: Stop, time_s: float) -> None:
        """Comes to rest along a path, and stays at its end.

        Args:
            stop: the path, and the time along it.
            time_s: the time of the stop that belongs to the setpoint that was streamed last.
        """
        self._stop, self._stop_begin_s = stop, self._streamed_s - time_s
        self.brake()

    def sent(self, position: Ned) -> Ned:
        """The position that is sent for a position: higher if the vehicle is near the ground."""
        north, east, down = position
        return (north, east, down - self._ground.lift_m)

    def forget_setpoint(self) -> None:
        """Holds from now on where the vehicle is, not where its last setpoint was."""
        self._setpoint = self._stop = None

    @property
    def heading_rad(self) -> float:
        """The heading of the last setpoint; without one, the heading of the vehicle."""
        if self._setpoint is not None:
            return self._setpoint.yaw_rad
        state = self._vehicle.state
        return state.attitude.yaw_rad if state is not None else 0.0

    def hold(self, heading_rad: float | None = None) -> None:
        """Holds at the last setpoint, or without one where the vehicle is in the air.

        If a pilot has given it back a little above its altitudes, it comes down to them.

        Args:
            heading_rad: the heading to which it turns; None to keep the heading.
        """
        state = self._vehicle.state
        if self._stop is not None:
            return
        if self._setpoint is not None:
            at_rest = _rest_at(self._setpoint.position)
            self._stream(at_rest, heading_rad, is_landing=self._is_landing)
        elif state is not None and not state.is_landed:
            self._stream(_rest_at(self._not_above_band(state.motion.position)), heading_rad)

    def hold_unless_commanded(self) -> None:
        """Holds, if nothing else was streamed in this tick."""
        if self._streamed_s < self._now():
            self.hold()

    def _not_above_band(self, position: Ned) -> Ned:
        """A position, or the highest one below it that is allowed, if that is near enough."""
        north, east, down = position
        highest_down = -self._limits.up_m[1]
        is_near = highest_down - down < self._profile.carrot_m
        return (north, east, highest_down) if down < highest_down and is_near else position

    def hold_here(self) -> None:
        """Holds the horizontal position, while the vehicle may still climb.

        The setpoint takes the height of the vehicle, but keeps its horizontal position: if it
        followed the vehicle, the wind would carry it away. A vehicle that has moved further, as in
        the hands of a pilot, is held where it is.
        """
        told, state = self._setpoint, self._vehicle.state
        self.forget_setpoint()
        if state is None or state.is_landed:
            return
        north, east, down = state.motion.position
        if told is not None and math.dist(told.position[:2], (north, east)) < HELD_M:
            north, east, _ = told.position
        self._stream(_rest_at(self._not_above_band((north, east, down))), None)

    def _stream(
        self,
        sample: Sample,
        heading_rad: float | None,
        *,
        is_for_task: bool = False,
        is_landing: bool = False,
    ) -> None:
        yaw_rad = self._turned(heading_rad)
        setpoint = Setpoint(sample.position, sample.velocity, sample.fed_forward, yaw_rad)
        self._setpoint, self._streamed_s = setpoint, self._now()
        self._is_landing = is_landing
        position, near = self._walls.kept_off(sample, self._vehicle.state)
        if near is not None:
            self._report(near)
        if position != sample.position:
            setpoint = replace(setpoint, position=position)
        setpoint, low = self._ground.kept_off(setpoint, self._vehicle.state, is_landing)
        if low is not None:
            self._report(low)
        self._vehicle.setpoints.fly(setpoint, is_for_task=is_for_task, is_landing=is_landing)

    def _turned(self, heading_rad: float | None) -> float:
        """The next heading: the one before, turned no faster than the profile allows."""
        now_rad = self.heading_rad
        if heading_rad is None:
            return now_rad
        most_rad = self._profile.yaw_rate_radps * min(self._now() - self._streamed_s, 2 * TICK_S)
        return turned(now_rad, heading_rad, most_rad)


def _rest_at(position: Ned) -> Sample:
    return Sample(position, AT_REST, AT_REST, is_finished=True)
