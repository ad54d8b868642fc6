"""What behaviours act on: the vehicle, the task, the map, the clock, and the plan's progress."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from companion.acting.docks import AnyDock, Dock
from companion.acting.function_port import FunctionPort, NoFunctions
from companion.acting.ground_guard import GroundGuard
from companion.acting.journal import CommandIntended, CommandSettled, Journal, NoJournal
from companion.acting.symbols import Symbols
from companion.acting.wall_guard import WallGuard
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.skills import SymbolMoved
from companion.geofence import KeptFence
from companion.geometry import Ned, distance, times
from companion.mission.model import Limits
from companion.mission.signals import Signal
from companion.motion.departure import Departure, at_rest
from companion.motion.drag_estimate import DragEstimate
from companion.motion.heading import turned
from companion.motion.layered_routes import LayeredRoutes
from companion.motion.live_speed_limit import LiveSpeedLimit
from companion.motion.trajectory import AT_REST, Sample, Stop, Trajectory
from companion.planning.task_state import TaskState
from companion.vehicle.port import Failed, Setpoint, Vehicle, VehicleState
from companion.vehicle_profile import VehicleProfile

TICK_S = 0.05
"""Period of ticks, setpoints and everything else that the companion does: 20 Hz."""
HELD_M = 0.5
"""Nearer to its setpoint a vehicle is held there, and does not have it moved to where it is."""
LAG_SHARE = 0.6
"""Of the gate's carrot: distance behind its setpoint at which the vehicle counts as behind."""


@dataclass
class PlanProgress:
    """How far a plan has come. Each plan has its own; nodes of its tree write it.

    Attributes:
        completed: skills that were completed; `Effects` counts them.
        laps: laps of the loop; `Effects` counts them.
        is_landed_by_plan: the plan has landed the vehicle, and has not taken off again; the leaves
            that land and take off write it, and who interrupts the plan in the air.
        is_stranded: an action has failed there; `ActionNode` writes it.
        is_descending: the vehicle comes down to the marker of its place; the leaf writes it.
        unnoticed_landing: the autopilot lands, and does not say that it has; the leaves that land
            write it.
        is_disarmed: somebody, or a crash, has disarmed it in a take-off; that leaf writes it.
    """

    completed: int = 0
    laps: int = 0
    is_landed_by_plan: bool = False
    is_stranded: bool = False
    is_descending: bool = False
    unnoticed_landing: Failed | None = None
    is_disarmed: bool = False


@dataclass
class Flight:
    """One flight of one mission, shared by all behaviours of its tree.

    Its parts are given once. Each other field has one writer.

    Attributes:
        speed_limit: of all that is flown.
        profile: of the vehicle that the mission is written for.
        limits: of the mission.
        symbols: where each place is to be flown to; read late, so that it may change in flight.
        now_s: time of the tick; the sortie writes it before all else.
        progress: of the present plan; the executive gives each plan its own.
        drag: of the vehicle, as it is learnt in flight; the run feeds it.
        belief_retry_s: time after which a belief that a failure withdrew is held again, where the
            mission does not say; None is never. The run writes it, as the operator sets it.
        reports: what happened and has not been collected yet; the flight's own methods write it.
        journal: keeps what another process needs to go on with the flight; the run gives it.
        functions: calls functions of installed packages.
        dock: the one on which the vehicle charges; assembly gives it where plans know of energy.
        is_task_flown: what is flown is the plan of the task; `FlownTask` writes it.
        heard: when each signal was heard last, and its value.
        believed_percent: of the charge, where the gauge tells more than can be; `energy_gauge.py`
            writes it.
        kept_fence: of somebody else, to which it keeps; `kept_fence.py` writes it.
    """

    vehicle: Vehicle
    task: TaskState
    routes: LayeredRoutes
    speed_limit: LiveSpeedLimit
    profile: VehicleProfile
    limits: Limits
    symbols: Symbols
    now_s: float = 0.0
    progress: PlanProgress = field(default_factory=PlanProgress)
    drag: DragEstimate = field(default_factory=DragEstimate)
    belief_retry_s: float | None = None
    reports: list[Stamped] = field(default_factory=list)
    journal: Journal = field(default_factory=NoJournal)
    functions: FunctionPort = field(default_factory=NoFunctions)
    dock: Dock = field(default_factory=AnyDock)
    is_task_flown: bool = False
    heard: dict[Signal, tuple[float, float]] = field(default_factory=dict)
    believed_percent: int = 100
    kept_fence: KeptFence | None = None
    _intentions: int = field(default=0, init=False)
    _setpoint: Setpoint | None = field(default=None, init=False)
    _is_landing: bool = field(default=False, init=False)
    _stop: Stop | None = field(default=None, init=False)
    _stop_begin_s: float = field(default=0.0, init=False)
    _streamed_s: float = field(default=0.0, init=False)
    _walls: WallGuard = field(init=False)
    _ground: GroundGuard = field(init=False)

    def __post_init__(self) -> None:
        """The guards know the flight's own routes."""
        self._walls = WallGuard(self.routes, self.profile)
        self._ground = GroundGuard(self.routes, self.profile, self.limits.up_m[1])

    def elapsed_s(self, since_s: float) -> float:
        """Time since a step before; no more than two ticks, so that nothing jumps after a stall."""
        return min(self.now_s - since_s, 2 * TICK_S)

    def hear(self, readings: Sequence[tuple[Signal, float]]) -> Sequence[tuple[Signal, float]]:
        """Notes what was heard in this tick, and hands it on."""
        for signal, value in readings:
            self.heard[signal] = (self.now_s, value)
        return readings

    def report(self, event: FlightEvent) -> None:
        """Notes something that happened now."""
        self.add_report(Stamped(round(self.now_s, 3), event))

    def add_report(self, stamped: Stamped) -> None:
        """Notes something that happened beside the flight, at its own time."""
        self.reports.append(stamped)

    def collect_reports(self) -> list[Stamped]:
        """Hands out what has happened since the last call."""
        collected, self.reports = self.reports, []
        return collected

    def tell_symbol(self, place: str) -> None:
        """Notes that a place is flown to at another waypoint."""
        value = self.symbols[place]
        self.report(SymbolMoved(place, value.position, value.source))

    def intend(self, command: str) -> int:
        """Notes that the skill under way is about to send a command; returns a number for it."""
        self._intentions += 1
        action = self.task.running.name if self.task.running is not None else ""
        self.journal.note(self.now_s, CommandIntended(self._intentions, action, command))
        return self._intentions

    def settle(self, intention: int) -> None:
        """Notes that a command has failed, or that it is given up."""
        self.journal.note(self.now_s, CommandSettled(intention))

    @property
    def setpoint(self) -> Setpoint | None:
        """What is streamed; None while it is not known where the vehicle is told to be."""
        return self._setpoint

    @property
    def approaches_wall(self) -> bool:
        """Whether the vehicle swings towards a wall, from where it is told to be."""
        told, state = self._setpoint, self.vehicle.state
        if told is None or state is None:
            return False
        return self._walls.is_approached(told.position, state)

    @property
    def stop(self) -> Stop | None:
        """How it brakes along the path that was flown before; None if it does not."""
        return self._stop

    @property
    def stopping_s(self) -> float:
        """The time since that began."""
        return self.now_s - self._stop_begin_s

    @property
    def departure(self) -> Departure | None:
        """How a flight would begin now; None while nothing is known of the vehicle."""
        state = self.vehicle.state
        return None if state is None else self.departure_of(state)

    def departure_of(self, state: VehicleState) -> Departure:
        """The same for a state: the motion that it is told, if it follows that; else its own.

        A vehicle above its altitudes comes down to them as it leaves.
        """
        told, stop, t_s = self._setpoint, self._stop, self.stopping_s
        within_m = LAG_SHARE * self.profile.carrot_m
        if told is None or distance(self.sent(told.position), state.position) >= within_m:
            here = self._not_above_band(state.position)
            own = Sample(here, state.velocity, AT_REST, is_finished=False)
            return Departure(own, stop, t_s)
        return at_rest(told.position) if stop is None else Departure(stop.sample(t_s), stop, t_s)

    def led(self, flown: Trajectory | Stop, t_s: float) -> Sample:
        """A moment with the acceleration that the vehicle is told: that of a little later.

        Its own follows by `response_s`, its controller takes a share away (`feed_forward`), and the
        air takes what its drag is.
        """
        profile = self.profile
        later = flown.sample(t_s + profile.response_s)
        north, east, down = times(later.acceleration, profile.feed_forward)
        v_north, v_east, _ = times(later.velocity, self.drag.per_s)
        told = (north + v_north, east + v_east, down)
        return replace(flown.sample(t_s), acceleration=told)

    def learn(self, state: VehicleState) -> None:
        """Takes what the vehicle's motion says of its drag; once a tick."""
        if state.is_landed:
            self.drag.pause()
        else:
            self.drag.take(state.measured_s, state.velocity[:2], state.thrust_mps2)

    def brake(self) -> None:
        """Goes on with a stop; once a tick, before anything else acts."""
        if self._stop is None:
            return
        sample = self.led(self._stop, self.stopping_s)
        self._stream(sample, None)
        if sample.is_finished:
            self._stop = None

    def fly(self, sample: Sample, heading_rad: float | None = None) -> None:
        """Streams a moment of a flight from now on.

        Args:
            sample: where the vehicle shall be, and how it shall move.
            heading_rad: to which it turns, as fast as it may; None to keep the heading.
        """
        self._stop = None
        self._stream(sample, heading_rad, self.is_task_flown)

    def descend(self, sample: Sample) -> None:
        """Streams a moment of the way down to a marker, or of the search for it."""
        self._stop = None
        self._stream(sample, None, self.is_task_flown, is_landing=True)

    def stop_along(self, stop: Stop, time_s: float) -> None:
        """Comes to rest along a path, and stays at its end.

        Args:
            stop: how.
            time_s: its time at the setpoint that was streamed last.
        """
        self._stop, self._stop_begin_s = stop, self._streamed_s - time_s
        self.brake()

    def sent(self, position: Ned) -> Ned:
        """Where a position is truly sent to: higher, where the ground is nearer than it may be."""
        north, east, down = position
        return (north, east, down - self._ground.lift_m)

    def forget_setpoint(self) -> None:
        """Holds from now on where the vehicle is, not where its last setpoint was."""
        self._setpoint = self._stop = None

    @property
    def heading_rad(self) -> float:
        """The heading that was told last, or that of the vehicle."""
        before = self._setpoint or self.vehicle.state
        return before.yaw_rad if before is not None else 0.0

    def hold(self, heading_rad: float | None = None) -> None:
        """Stays where the last setpoint was, or where the vehicle is in the air.

        A little above its altitudes, where a pilot may have given it back, it comes down to them.

        Args:
            heading_rad: to which it turns; None to keep the heading.
        """
        state = self.vehicle.state
        if self._stop is not None:
            return
        if self._setpoint is not None:
            at_rest = _rest_at(self._setpoint.position)
            self._stream(at_rest, heading_rad, is_landing=self._is_landing)
        elif state is not None and not state.is_landed:
            self._stream(_rest_at(self._not_above_band(state.position)), heading_rad)

    def hold_unless_told(self) -> None:
        """Holds where nothing was told in this tick, and the plan has the vehicle in the air."""
        if self._streamed_s < self.now_s and not self.progress.is_landed_by_plan:
            self.hold()

    def _not_above_band(self, position: Ned) -> Ned:
        """A position, or the highest one below it that is allowed, if that is a setpoint away."""
        north, east, down = position
        highest_down = -self.limits.up_m[1]
        is_near = highest_down - down < self.profile.carrot_m
        return (north, east, highest_down) if down < highest_down and is_near else position

    def hold_here(self) -> None:
        """Stays over where the vehicle is, at the height that it comes to; for one that may climb.

        Once held there it stays there: a setpoint that went with the vehicle would leave it to the
        wind. One that has gone further, as in the hands of a pilot, is held where it is then.
        """
        told, state = self._setpoint, self.vehicle.state
        self.forget_setpoint()
        if state is None or state.is_landed:
            return
        north, east, down = state.position
        if told is not None and math.dist(told.position[:2], (north, east)) < HELD_M:
            north, east, _ = told.position
        self._stream(_rest_at(self._not_above_band((north, east, down))), None)

    def _stream(
        self,
        sample: Sample,
        heading_rad: float | None,
        is_for_task: bool = False,
        is_landing: bool = False,
    ) -> None:
        yaw_rad = self._turned(heading_rad)
        setpoint = Setpoint(sample.position, sample.velocity, sample.acceleration, yaw_rad)
        self._setpoint, self._streamed_s = setpoint, self.now_s
        self._is_landing = is_landing
        position, near = self._walls.kept_off(sample, self.vehicle.state)
        if near is not None:
            self.report(near)
        if position != sample.position:
            setpoint = replace(setpoint, position=position)
        setpoint, low = self._ground.kept_off(setpoint, self.vehicle.state, is_landing)
        if low is not None:
            self.report(low)
        self.vehicle.fly(setpoint, is_for_task, is_landing)

    def _turned(self, heading_rad: float | None) -> float:
        """The heading that is told next: that of before, turned no faster than the vehicle may."""
        now_rad = self.heading_rad
        if heading_rad is None:
            return now_rad
        most_rad = self.profile.yaw_rate_radps * self.elapsed_s(self._streamed_s)
        return turned(now_rad, heading_rad, most_rad)


def _rest_at(position: Ned) -> Sample:
    return Sample(position, AT_REST, AT_REST, is_finished=True)
