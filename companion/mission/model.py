"""A mission as the rest of the program sees it: frozen, checked, in SI units and local NED.

`loader.py` makes it from YAML. Nothing here knows about files or YAML. Names (places, skills,
events, components) are the mission's own and are the same in logs, messages and tests.
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
        up_m: how high above home; of a place, the ground there.
        gimbal: component that looks at it too; None for none.
    """

    name: str
    position: NorthEast
    up_m: float = 0.0
    gimbal: int | None = None


@dataclass(frozen=True, slots=True)
class Place:
    """A named point with a region around it; `at(name)` holds inside the region.

    Attributes:
        heading_rad: with which the vehicle arrives, clockwise from north; None for any.
        amsl_m: its altitude above mean sea level, if it was given so.
        marker: below it; None if there is none.
        suggesters, tests: installed functions that propose waypoints of it, and judge them.
        found_by: the event that comes when it is found in flight, somewhere in its region; "" for a
            place that is known from the beginning.
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
        """Radius of the disc about it that its region holds."""
        return self.region.inner_m(self.position)

    @property
    def point(self) -> PointOfInterest:
        """The place as something to look at."""
        return PointOfInterest(self.name, (self.position[0], self.position[1]))


@dataclass(frozen=True, slots=True)
class Limits:
    """Bounds that no setpoint leaves.

    Attributes:
        speed_mps: greatest speed.
        up_m: lowest and highest flight altitude above home.
        fence: polygon of north-east corners.
        keep_out: the same of each area that is never entered, by name.
        is_fence_written: the mission has a fence of its own; else it is the edge of its map.
        is_beyond_sight: a vehicle with a range finder may fly faster than it can stop within what
            that sees.
    """

    speed_mps: float
    up_m: tuple[float, float]
    fence: tuple[NorthEast, ...]
    keep_out: Mapping[str, tuple[NorthEast, ...]] = field(default_factory=dict)
    is_fence_written: bool = True
    is_beyond_sight: bool = False


@dataclass(frozen=True, slots=True)
class Event:
    """A fact that the vehicle cannot choose, read off the wire (Section III-B).

    It becomes true when `when` has held for `for_s`; false when `until` (default: not `when`)
    has held for `for_s`, or never again if `latch`. A command has no duration: it counts at once.
    What was not heard for `stale_s` is not known: it changes nothing, but where silence is what is
    asked for.
    When the event becomes true, the conjuncts named in `restarts` begin anew: what they still
    demanded from positions before is dropped; and withdrawn beliefs with a predicate of `restores`
    are held again.
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
        """What holds when it has become true."""
        return Fact(self.name)

    @property
    def is_pulse(self) -> bool:
        """Whether it falls in the moment in which it rises."""
        return self.when.signal.is_pulse and self.until is None and not self.latch

    @property
    def duration(self) -> str:
        """When it holds, in words."""
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
    """An effect that only comes if a condition holds before the skill."""

    condition: tuple[Literal, ...]
    effect: tuple[Literal, ...]


@dataclass(frozen=True, slots=True)
class Skill:
    """The paper's action template (Section II-E) with beliefs and its refinement.

    Attributes:
        parameters: (parameter name, set name) in order.
        precondition: conjunction of literals over the parameters.
        assumes: beliefs that are taken for true until the skill fails.
        effect: literals that hold afterwards.
        conditional: further effects, each under a condition.
        distinct: groups of parameters, places and objects, no two of which are the same.
        cost_s: constant cost in seconds; None means what its steps take, flights on the map.
        execute: its refinement, one step after the other.
        tries: how often its refinement is tried before it has failed (MAX_TRY, Fig. 6).
        timeout_s: longest time of one try; None for no limit.
        is_planned: whether the planner may use it; if not it only refines other skills.
        retry_after_s: time after which a belief that its failure withdrew is held again.
        look_at: what the vehicle looks at meanwhile: one of its parameters, or always the same.
        is_repeatable: its commands may be sent again where it is not known whether they were done.
        confirmed_by: what has to be heard after its last step; None for nothing.
        gimbal: component that looks at it, too; None for the vehicle alone.
        energy_wh: what it takes beside flying or hovering.
        charge_rate: pairs of the charge, 0 to 1, and of its rise a second; falling.
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
        """The parameter that names where it begins: p with precondition at(p); None without one."""
        names = [name for name, _ in self.parameters]
        for literal in self.precondition:
            atom = literal.atom
            if literal.is_positive and atom.predicate == AT and atom.arguments[0] in names:
                return atom.arguments[0]
        return None


PATIENCE_S = 60.0
"""How long a vehicle without a plan holds, where the mission does not say."""


class Otherwise(Enum):
    """The behaviour when no plan exists."""

    RETURN_HOME = "return_home"
    LAND = "land"
    HOLD = "hold"


@dataclass(frozen=True, slots=True)
class LandAtSafePlace:
    """The same: to land at one of some places, at the one that is reached soonest.

    >>> print(LandAtSafePlace(("Home", "North", "South")))
    Home, North or South
    """

    places: tuple[str, ...]

    def __str__(self) -> str:
        *others, last = self.places
        return f"{', '.join(others)} or {last}" if others else last


@dataclass(frozen=True, slots=True)
class Mission:
    """Everything the mission file says.

    Attributes:
        sets: members of each set: places, and objects that are no places.
        task: named lines, in the order of the file; a plain goal is the line `goal`.
        ready: lines that shall hold whenever their event may come.
        lines_at: where each line stands in the file, or in the data, for messages.
        priorities: of the lines that may be dropped; the higher, the more important.
        initially: facts that hold at the start, beliefs left out; all others are false.
        grid: what the vehicle is told of the map beforehand.
        map_file, walls: the file it is read from, or "" and what the mission draws.
        battery: what plans reckon with; None for plans that know of no energy.
        tree: the plan, if it was written by hand; the task is then not planned for.
        vehicle: what it is written for.
        patience_s: how long a vehicle without a plan holds, where one may become possible again.
        anchor: where north 0, east 0 lies on the earth, in a mission with frame: wgs84; its
            altitude is an assumption. None for metres from wherever home is.
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
        """Whether a place of it was given above the sea."""
        return any(place.amsl_m is not None for place in self.places.values())

    @property
    def optional(self) -> tuple[str, ...]:
        """The lines that may be dropped, the most important first, ties in file order."""
        return tuple(sorted(self.priorities, key=lambda line: -self.priorities[line]))

    @property
    def written_task(self) -> dict[str, str]:
        """The lines of the task as texts."""
        return {name: str(line) for name, line in self.task.items()}

    @property
    def is_timed(self) -> bool:
        """Whether its task has bounds in time."""
        return any(isinstance(line, TimedFormula) for line in self.task.values())

    @property
    def speed_limits(self) -> SpeedLimits:
        """The limits of its flights: the vehicle's, and no faster than the mission allows."""
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
        """Where the vehicle is to land when no plan exists, at any of them; () for nowhere."""
        match self.otherwise:
            case LandAtSafePlace(places):
                return places
            case Otherwise.RETURN_HOME:
                return (self.home.name,)
        return ()

    @property
    def task_facts(self) -> frozenset[Fact]:
        """The facts that the task speaks of."""
        lines = map(untimed, self.task.values())
        return frozenset(Fact.parse(p) for line in lines for p in atoms(line))
