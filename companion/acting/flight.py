"""What behaviours act on: the vehicle, its guidance, the task, the map, and the plan's progress."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from companion.acting.begun_steps import BegunSteps
from companion.acting.docks import AnyDock, Dock
from companion.acting.function_port import FunctionPort, NoFunctions
from companion.acting.guidance import Guidance
from companion.acting.journal import Journal, JournalEntry, NoJournal
from companion.acting.plan_progress import PlanProgress
from companion.acting.symbols import Symbols
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.skills import SymbolMoved
from companion.geofence import KeptFence
from companion.mission.places import Limits
from companion.mission.signals import Signal
from companion.motion.layered_routes import LayeredRoutes
from companion.motion.live_speed_limit import LiveSpeedLimit
from companion.planning.task_state import TaskState
from companion.tick import TICK_S
from companion.vehicle.ports.cameras import ShotOwner
from companion.vehicle.ports.vehicle import Vehicle
from companion.vehicle_profile import VehicleProfile


@dataclass
class Flight:
    """One flight of one mission, shared by all behaviours of its tree.

    Its parts are given once. Each other field has one writer.

    Attributes:
        speed_limit: the limit for everything that is flown.
        profile: the profile of the vehicle that the mission is written for.
        limits: the mission's limits.
        symbols: the waypoint of each place; read as late as possible, because it may change in
            flight.
        now_s: time of the tick; the sortie writes it before all else.
        progress: of the present plan; the executive gives each plan its own.
        belief_retry_s: time after which a belief that a failure withdrew is held again, unless the
            mission says so; None for never. The run writes what the operator sets.
        reports: what has happened and was not collected yet; written by the flight's own methods.
        journal: stores what another process needs to continue the flight; the run gives it.
        functions: calls functions of installed packages.
        dock: the dock on which the vehicle charges.
        heard: when each signal was last heard, and its value.
        believed_percent: the charge, if the gauge shows more than possible; `energy_gauge.py`
            writes it.
        guidance: makes the setpoints.
        steps: the steps that must not be done twice; the leaves of the tree write them.
        kept_fence: somebody else's fence to which the flight keeps; `kept_fence.py` writes it.
        photos_reported: what the reported photos were for; `photo.py` writes it.
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
    belief_retry_s: float | None = None
    reports: list[Stamped] = field(default_factory=list)
    journal: Journal = field(default_factory=NoJournal)
    functions: FunctionPort = field(default_factory=NoFunctions)
    dock: Dock = field(default_factory=AnyDock)
    heard: dict[Signal, tuple[float, float]] = field(default_factory=dict)
    believed_percent: int = 100
    kept_fence: KeptFence | None = None
    photos_reported: set[ShotOwner] = field(default_factory=set)
    guidance: Guidance = field(init=False)
    steps: BegunSteps = field(init=False)

    def __post_init__(self) -> None:
        """Lets guidance and steps use the flight's own time, and report to it or its journal."""
        self.steps = BegunSteps(self._forget_command, self.note)
        self.guidance = Guidance(
            self.vehicle, self.routes, self.profile, self.limits, lambda: self.now_s, self.report
        )

    def _forget_command(self, ticket: int) -> None:
        self.vehicle.payloads.forget(ticket)

    def elapsed_s(self, since_s: float) -> float:
        """Time since an earlier step; at most two ticks, so that nothing jumps after a stall."""
        return min(self.now_s - since_s, 2 * TICK_S)

    def hold_unless_commanded(self) -> None:
        """Holds if no setpoint was made in this tick and the plan has the vehicle in the air."""
        if not self.progress.is_landed_by_plan:
            self.guidance.hold_unless_commanded()

    def hear(self, readings: Sequence[tuple[Signal, float]]) -> Sequence[tuple[Signal, float]]:
        """Notes what was heard in this tick, and returns it."""
        for signal, value in readings:
            self.heard[signal] = (self.now_s, value)
        return readings

    def report(self, event: FlightEvent) -> None:
        """Notes something that happened now."""
        self.add_report(Stamped(round(self.now_s, 3), event))

    def note(self, entry: JournalEntry) -> None:
        """Adds an entry to the journal, with the present time."""
        self.journal.note(self.now_s, entry)

    def add_report(self, stamped: Stamped) -> None:
        """Notes something that happened beside the flight, with its own time."""
        self.reports.append(stamped)

    def collect_reports(self) -> list[Stamped]:
        """Returns what has happened since the last call."""
        collected, self.reports = self.reports, []
        return collected

    def tell_symbol(self, place: str) -> None:
        """Reports that the waypoint of a place has changed."""
        value = self.symbols[place]
        self.report(SymbolMoved(place, value.position, value.source))
