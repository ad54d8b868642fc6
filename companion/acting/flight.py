"""What behaviours act on: the vehicle, the task, the map, the clock, and the last failure."""

from __future__ import annotations

from dataclasses import dataclass, field

from companion.acting.report import Report
from companion.acting.symbols import Symbols
from companion.motion.live_speed_limit import LiveSpeedLimit
from companion.motion.routes import RouteMap
from companion.planning.task_state import TaskState
from companion.vehicle.port import Setpoint, Vehicle, hold_at
from companion.vehicle_profile import VehicleProfile

TICK_S = 0.05
"""Period of ticks, setpoints and everything else that the companion does: 20 Hz."""


@dataclass
class Flight:
    """One flight of one mission, shared by all behaviours of its tree.

    Attributes:
        speed_limit: of all that is flown.
        profile: of the vehicle that the mission is written for.
        symbols: where each place is to be flown to; read late, so that it may change in flight.
        now_s: time of the tick, set before each tick.
        completed: skills of the present plan that were completed.
        laps: laps of the present plan's loop.
        failure: why the last skill failed.
        may_do_better: a belief has come back, so that another plan may be better.
        belief_retry_s: time after which a belief that a failure withdrew is held again, where the
            mission does not say; None is never.
        is_grounded: the plan has landed the vehicle, and has not taken off again.
        reports: what happened and has not been collected yet.
    """

    vehicle: Vehicle
    task: TaskState
    routes: RouteMap
    speed_limit: LiveSpeedLimit
    profile: VehicleProfile
    symbols: Symbols
    now_s: float = 0.0
    completed: int = 0
    laps: int = 0
    failure: str = ""
    may_do_better: bool = False
    is_grounded: bool = False
    belief_retry_s: float | None = None
    reports: list[Report] = field(default_factory=list)
    setpoint: Setpoint | None = None

    def report(self, kind: str, text: str, **data: object) -> None:
        """Notes something that happened now."""
        self.reports.append(Report(round(self.now_s, 3), kind, text, data))

    def tell_symbol(self, place: str) -> None:
        """Notes that a place is flown to at another waypoint."""
        value = self.symbols[place]
        north, east, _ = value.position
        text = f"{place} is now {east:.1f} m east, {north:.1f} m north ({value.source})"
        self.report("symbol", text, place=place, position=value.position, source=value.source)

    def fly(self, setpoint: Setpoint) -> None:
        """Streams a setpoint from now on."""
        self.setpoint = setpoint
        self.vehicle.fly(setpoint)

    def hold(self) -> None:
        """Stays where the last setpoint was, or where the vehicle is in the air."""
        state = self.vehicle.state
        if self.setpoint is not None:
            self.fly(hold_at(self.setpoint.position, self.setpoint.yaw_rad))
        elif state is not None and not state.is_landed:
            self.fly(hold_at(state.position, state.yaw_rad))
