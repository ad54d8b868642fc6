"""What behaviours act on: the vehicle, its guidance, the task, the map, and the plan's progress."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from companion.acting.begun_steps import BegunSteps
from companion.acting.docks import AnyDock, Dock
from companion.acting.function_port import FunctionPort, NoFunctions
from companion.acting.guidance import Guidance
from companion.acting.journal import Journal, JournalEntry, NoJournal
from companion.acting.symbols import Symbols
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.skills import SymbolMoved
from companion.geofence import KeptFence
from companion.mission.model import Limits
from companion.mission.signals import Signal
from companion.motion.layered_routes import LayeredRoutes
from companion.motion.live_speed_limit import LiveSpeedLimit
from companion.planning.task_state import TaskState
from companion.tick import TICK_S
from companion.vehicle.port import Failed, Vehicle
from companion.vehicle_profile import VehicleProfile


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
        belief_retry_s: time after which a belief that a failure withdrew is held again, where the
            mission does not say; None is never. The run writes it, as the operator sets it.
        reports: what happened and has not been collected yet; the flight's own methods write it.
        journal: keeps what another process needs to go on with the flight; the run gives it.
        functions: calls functions of installed packages.
        dock: the one on which the vehicle charges; assembly gives it where plans know of energy.
        heard: when each signal was heard last, and its value.
        believed_percent: of the charge, where the gauge tells more than can be; `energy_gauge.py`
            writes it.
        guidance: what the vehicle is told to fly.
        steps: those that must not be done twice; the leaves of the tree write them.
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
    belief_retry_s: float | None = None
    reports: list[Stamped] = field(default_factory=list)
    journal: Journal = field(default_factory=NoJournal)
    functions: FunctionPort = field(default_factory=NoFunctions)
    dock: Dock = field(default_factory=AnyDock)
    heard: dict[Signal, tuple[float, float]] = field(default_factory=dict)
    believed_percent: int = 100
    kept_fence: KeptFence | None = None
    guidance: Guidance = field(init=False)
    steps: BegunSteps = field(init=False)

    def __post_init__(self) -> None:
        """Guidance and steps use the flight's own time, and report to it or to its journal."""
        self.steps = BegunSteps(self.vehicle, self.note)
        self.guidance = Guidance(
            self.vehicle, self.routes, self.profile, self.limits, lambda: self.now_s, self.report
        )

    def elapsed_s(self, since_s: float) -> float:
        """Time since a step before; no more than two ticks, so that nothing jumps after a stall."""
        return min(self.now_s - since_s, 2 * TICK_S)

    def hold_unless_told(self) -> None:
        """Holds where nothing was told in this tick, and the plan has the vehicle in the air."""
        if not self.progress.is_landed_by_plan:
            self.guidance.hold_unless_told()

    def hear(self, readings: Sequence[tuple[Signal, float]]) -> Sequence[tuple[Signal, float]]:
        """Notes what was heard in this tick, and hands it on."""
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
