"""A mission as the rest of the program sees it: frozen, checked, in SI units and local NED.

`loader.py` makes it from YAML; this module knows nothing of files. Names (places, skills, events,
components) are the mission's own, and are the same in logs, messages and tests.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

from companion.battery_profile import Points
from companion.drawn_maps import Wall
from companion.errors import KeyPath, Location
from companion.geometry import GlobalOrigin, Ned, NorthEast
from companion.ltl.formula import atoms
from companion.ltl.timed_formula import Line, TimedFormula, untimed
from companion.mission.battery import MissionBattery
from companion.mission.facts import AT, Atom, Fact, at
from companion.mission.markers import LandingMarker
from companion.mission.python_call import PythonCall
from companion.mission.signals import AnyCondition, Condition
from companion.mission.steps import Charge as Charge
from companion.mission.steps import Command as Command
from companion.mission.steps import Do as Do
from companion.mission.steps import Execution as Execution
from companion.mission.steps import Fly as Fly
from companion.mission.steps import Land as Land
from companion.mission.steps import LandOn as LandOn
from companion.mission.steps import TakeOff as TakeOff
from companion.mission.steps import Wait as Wait
from companion.mission.tree_nodes import Tree
from companion.motion.grid import OccupancyGrid
from companion.motion.profile import SpeedLimits
from companion.motion.region import Region
from companion.vehicle_profile import VehicleProfile


@dataclass(frozen=True, slots=True)
class PointOfInterest:
    """What the vehicle looks at: a place, or a point to which it need not be able to fly.

    Attributes:
        up_m: height above home; for a place, the height of the ground there.
        gimbal: component that also looks at it; None for none.
    """

    name: str
    position: NorthEast
    up_m: float = 0.0
    gimbal: int | None = None


@dataclass(frozen=True, slots=True)
class Place:
    """A named point with a region around it; `at(name)` holds inside the region.

    Attributes:
        heading_rad: the vehicle's heading on arrival, clockwise from north; None for any.
        amsl_m: its altitude above mean sea level, if the mission gives that.
        marker: the marker below it; None if there is none.
        suggesters, tests: installed functions that propose waypoints in it, and judge them.
        found_by: the event that reports where in its region the place is; "" for a place that is
            known from the beginning.
    """

    name: str
    position: Ned
    region: Region
    heading_rad: float | None = None
    amsl_m: float | None = None
    marker: LandingMarker | None = None
    suggesters: tuple[PythonCall, ...] = ()
    tests: tuple[PythonCall, ...] = ()
    found_by: str = ""

    @property
    def inner_m(self) -> float:
        """Radius of the largest disc around the point that the region contains."""
        return self.region.inner_m(self.position)

    @property
    def point(self) -> PointOfInterest:
        """The place as something to look at."""
        return PointOfInterest(self.name, (self.position[0], self.position[1]))


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits that no setpoint exceeds.

    Attributes:
        speed_mps: greatest speed.
        up_m: lowest and highest flight altitude above home.
        fence: polygon of north-east corners.
        keep_out: the polygon of each area that is never entered, by name.
        is_fence_written: whether the mission gives a fence; if not, the map's edge is the fence.
        is_beyond_sight: whether a vehicle with a range finder may fly too fast to stop within the
            distance that it sees.
    """

    speed_mps: float
    up_m: tuple[float, float]
    fence: tuple[NorthEast, ...]
    keep_out: Mapping[str, tuple[NorthEast, ...]] = field(default_factory=dict)
    is_fence_written: bool = True
    is_beyond_sight: bool = False


@dataclass(frozen=True, slots=True)
class Event:
    """A fact that the vehicle cannot choose; it comes from received messages (Section III-B).

    It becomes true when `when` has held for `for_s`. It becomes false when `until` (default: not
    `when`) has held for `for_s`, or never if `latch`. A command has no duration: it counts at once.
    A signal that was not heard for `stale_s` is unknown: it changes nothing, except where the
    condition is silence.
    When the event becomes true, the conjuncts named in `restarts` start again, and what they still
    demanded because of earlier positions is dropped; withdrawn beliefs with a predicate in
    `restores` are held again.
    """

    name: str
    when: AnyCondition
    until: AnyCondition | None
    latch: bool
    for_s: float
    restarts: frozenset[str]
    restores: frozenset[str] = frozenset()
    stale_s: float | None = None

    @property
    def fact(self) -> Fact:
        """The fact that holds while the event is true."""
        return Fact(self.name)

    @property
    def is_pulse(self) -> bool:
        """Whether the event becomes false again at the moment at which it becomes true."""
        return self.when.signal.is_pulse and self.until is None and not self.latch

    @property
    def duration(self) -> str:
        """How long the event is true, in words."""
        if self.is_pulse:
            return f"at the moment of {self.when}, once in the word for each"
        delay = f"; a change counts after {self.for_s:g} s" if self.for_s else ""
        if self.latch:
            return f"for ever, once {self.when}{delay}"
        span = f"from {self.when} until {self.until}" if self.until else f"while {self.when}"
        return span + delay


@dataclass(frozen=True, slots=True)
class Literal:
    """An atom or its negation."""

    atom: Atom
    is_positive: bool


@dataclass(frozen=True, slots=True)
class ConditionalEffectTemplate:
    """An effect that happens only if a condition holds before the skill."""

    condition: tuple[Literal, ...]
    effect: tuple[Literal, ...]


@dataclass(frozen=True, slots=True)
class Skill:
    """The paper's action template (Section II-E), with beliefs and a refinement.

    Attributes:
        parameters: (parameter name, set name), in order.
        precondition: conjunction of literals over the parameters.
        assumes: beliefs that are assumed to be true until the skill fails.
        effect: literals that hold afterwards.
        conditional: further effects, each with a condition.
        distinct: groups of parameters, places and objects whose members must all differ.
        cost_s: constant cost in seconds; None for the time of its steps, with flights on the map.
        execute: its refinement, a sequence of steps.
        tries: how often the refinement is tried before the skill fails (MAX_TRY, Fig. 6).
        timeout_s: longest duration of one try; None for no limit.
        is_planned: whether the planner may use it; if not, it only refines other skills.
        retry_after_s: time after which beliefs that its failure withdrew are held again.
        look_at: what the vehicle looks at meanwhile: the place of a parameter, or a fixed point.
        is_repeatable: whether commands may be sent again if it is unknown whether they were done.
        confirmed_by: the condition that has to be heard after its last step; None for nothing.
        gimbal: component that also looks at it; None if only the vehicle turns.
        energy_wh: the energy that it takes in addition to flying or hovering.
        charge_rate: pairs of the charge (0 to 1) and its rise per second, which falls.
    """

    name: str
    parameters: tuple[tuple[str, str], ...]
    precondition: tuple[Literal, ...]
    assumes: tuple[Atom, ...]
    effect: tuple[Literal, ...]
    cost_s: float | None
    execute: tuple[Execution, ...]
    tries: int
    timeout_s: float | None
    conditional: tuple[ConditionalEffectTemplate, ...] = ()
    distinct: tuple[tuple[str, ...], ...] = ()
    is_planned: bool = True
    retry_after_s: float | None = None
    look_at: str | PointOfInterest | None = None
    is_repeatable: bool = False
    confirmed_by: Condition | None = None
    gimbal: int | None = None
    energy_wh: float = 0.0
    charge_rate: Points | None = None

    @property
    def origin(self) -> str | None:
        """The parameter p of a precondition at(p), where the skill begins; None without one."""
        names = [name for name, _ in self.parameters]
        for literal in self.precondition:
            atom = literal.atom
            if literal.is_positive and atom.predicate == AT and atom.arguments[0] in names:
                return atom.arguments[0]
        return None


PATIENCE_S = 60.0
"""How long a vehicle without a plan holds, unless the mission says otherwise."""


class Otherwise(Enum):
    """What the companion does when no plan exists."""

    RETURN_HOME = "return_home"
    LAND = "land"
    HOLD = "hold"


@dataclass(frozen=True, slots=True)
class LandAtSafePlace:
    """When no plan exists, the vehicle lands at whichever of these places it reaches soonest.

    >>> print(LandAtSafePlace(("Home", "North", "South")))
    Home, North or South
    """

    places: tuple[str, ...]

    def __str__(self) -> str:
        *others, last = self.places
        return f"{', '.join(others)} or {last}" if others else last


@dataclass(frozen=True, slots=True)
class Mission:
    """Everything that the mission file says.

    Attributes:
        sets: members of each set: places, and objects that are not places.
        task: named lines, in the order of the file; a plain goal is the line `goal`.
        ready: lines that plans must be able to keep whenever their event comes.
        lines_at: where each line is in the file, or in the data, for messages.
        priorities: of the lines that may be dropped; the higher, the more important.
        initially: facts that hold at the start, without beliefs; all others are false.
        grid: the map, as the vehicle knows it before the flight.
        map_file, walls: the map's file, or "" and the walls that the mission draws itself.
        battery: the battery that plans reckon with; None if plans ignore energy.
        tree: the plan, if it is written by hand; then the planner makes no plan for the task.
        vehicle: the vehicle for which the mission is written.
        patience_s: how long the vehicle holds without a plan, if a plan may become possible again.
        anchor: where north 0, east 0 lies on the earth, in a mission with frame: wgs84; its
            altitude is an assumption. None for a mission in metres from home.
    """

    name: str
    path: str
    text: str
    grid: OccupancyGrid
    limits: Limits
    places: Mapping[str, Place]
    sets: Mapping[str, tuple[str, ...]]
    events: Mapping[str, Event]
    skills: Mapping[str, Skill]
    initially: frozenset[Fact]
    task: Mapping[str, Line]
    otherwise: Otherwise | LandAtSafePlace
    tree: Tree | None = None
    vehicle: VehicleProfile = field(default_factory=VehicleProfile)
    patience_s: float = PATIENCE_S
    priorities: Mapping[str, int] = field(default_factory=dict)
    anchor: GlobalOrigin | None = None
    map_file: str = ""
    walls: tuple[Wall, ...] = ()
    battery: MissionBattery | None = None
    ready: tuple[str, ...] = ()
    lines_at: Mapping[str, Location | KeyPath] = field(default_factory=dict, compare=False)

    @property
    def is_above_sea(self) -> bool:
        """Whether any place was given above the sea."""
        return any(place.amsl_m is not None for place in self.places.values())

    @property
    def optional(self) -> tuple[str, ...]:
        """The lines that may be dropped, the most important first; ties are in file order."""
        return tuple(sorted(self.priorities, key=lambda line: -self.priorities[line]))

    @property
    def written_task(self) -> dict[str, str]:
        """The lines of the task as texts."""
        return {name: str(line) for name, line in self.task.items()}

    @property
    def is_timed(self) -> bool:
        """Whether any line of the task has a time bound."""
        return any(isinstance(line, TimedFormula) for line in self.task.values())

    @property
    def speed_limits(self) -> SpeedLimits:
        """The speed limits of the vehicle, with the speed capped at the limit of the mission."""
        vehicle = self.vehicle
        return SpeedLimits(
            min(self.limits.speed_mps, vehicle.speed_mps),
            vehicle.acceleration_mps2,
            vehicle.jerk_mps3,
            vehicle.climb_mps,
            vehicle.descent_mps,
        )

    @property
    def home(self) -> Place:
        """The place where the mission begins."""
        return next(p for name, p in self.places.items() if at(name) in self.initially)

    @property
    def safe_places(self) -> tuple[str, ...]:
        """The places at one of which the vehicle lands when no plan exists; () if it does not."""
        match self.otherwise:
            case LandAtSafePlace(places):
                return places
            case Otherwise.RETURN_HOME:
                return (self.home.name,)
        return ()

    @property
    def task_facts(self) -> frozenset[Fact]:
        """The facts that the task mentions."""
        lines = map(untimed, self.task.values())
        return frozenset(Fact.parse(p) for line in lines for p in atoms(line))
