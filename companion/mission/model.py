"""A mission as the rest of the program sees it: frozen, checked, in SI units and local NED.

`loader.py` makes it from YAML; this module knows nothing of files. Names (places, skills, events,
components) are the mission's own, and are the same in logs, messages and tests.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from companion.drawn_maps import Wall
from companion.errors import KeyPath, Location
from companion.geometry import GlobalOrigin
from companion.ltl.formula import atoms
from companion.ltl.timed_formula import Line, TimedFormula, untimed
from companion.mission.battery import MissionBattery
from companion.mission.events import Event
from companion.mission.facts import Fact, at
from companion.mission.otherwise import PATIENCE_S, LandAtSafePlace, Otherwise
from companion.mission.places import Limits, Place
from companion.mission.skills import Skill
from companion.mission.tree_nodes import Tree
from companion.motion.grid import OccupancyGrid
from companion.motion.profile import SpeedLimits
from companion.vehicle_profile import VehicleProfile


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
