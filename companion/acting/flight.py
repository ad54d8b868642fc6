"""What behaviours act on: the vehicle, the task, the map, the clock, and the plan's progress."""

from __future__ import annotations

from dataclasses import dataclass, field

from companion.acting.symbols import Symbols
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.skills import SymbolMoved
from companion.motion.live_speed_limit import LiveSpeedLimit
from companion.motion.routes import RouteMap
from companion.planning.task_state import TaskState
from companion.vehicle.port import Setpoint, Vehicle, hold_at
from companion.vehicle_profile import VehicleProfile

TICK_S = 0.05
"""Period of ticks, setpoints and everything else that the companion does: 20 Hz."""


@dataclass
class PlanProgress:
    """How far a plan has come. Each plan has its own; its leaves alone write it.

    Attributes:
        completed: skills that were completed.
        laps: laps of the loop.
        is_landed_by_plan: the plan has landed the vehicle, and has not taken off again.
    """

    completed: int = 0
    laps: int = 0
    is_landed_by_plan: bool = False


@dataclass
class Flight:
    """One flight of one mission, shared by all behaviours of its tree.

    Attributes:
        speed_limit: of all that is flown.
        profile: of the vehicle that the mission is written for.
        symbols: where each place is to be flown to; read late, so that it may change in flight.
        now_s: time of the tick, set before each tick.
        progress: of the present plan.
        belief_retry_s: time after which a belief that a failure withdrew is held again, where the
            mission does not say; None is never.
        reports: what happened and has not been collected yet.
    """

    vehicle: Vehicle
    task: TaskState
    routes: RouteMap
    speed_limit: LiveSpeedLimit
    profile: VehicleProfile
    symbols: Symbols
    now_s: float = 0.0
    progress: PlanProgress = field(default_factory=PlanProgress)
    belief_retry_s: float | None = None
    reports: list[Stamped] = field(default_factory=list)
    setpoint: Setpoint | None = None

    def report(self, event: FlightEvent) -> None:
        """Notes something that happened now."""
        self.reports.append(Stamped(round(self.now_s, 3), event))

    def tell_symbol(self, place: str) -> None:
        """Notes that a place is flown to at another waypoint."""
        value = self.symbols[place]
        self.report(SymbolMoved(place, value.position, value.source))

    def fly(self, setpoint: Setpoint) -> None:
        """Streams a setpoint from now on."""
        self.setpoint = setpoint
        self.vehicle.fly(setpoint)

    def forget_setpoint(self) -> None:
        """Holds from now on where the vehicle is, not where its last setpoint was."""
        self.setpoint = None

    def hold(self) -> None:
        """Stays where the last setpoint was, or where the vehicle is in the air."""
        state = self.vehicle.state
        if self.setpoint is not None:
            self.fly(hold_at(self.setpoint.position, self.setpoint.yaw_rad))
        elif state is not None and not state.is_landed:
            self.fly(hold_at(state.position, state.yaw_rad))
