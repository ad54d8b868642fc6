"""Flights in the bundled simulator, in lockstep in one process.

Besides the command line, this is the only module of the companion that imports the simulator.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from companion.acting.flight_limit import NO_LIMIT, FlightLimit
from companion.acting.sortie_terms import SortieTerms
from companion.api.flight_arguments import check_flight_arguments
from companion.api.results import FlightResult, FlownTrajectory, OnEvent, Recording, recording
from companion.app import Companion
from companion.arguments import check_kind
from companion.documents import Given, Source, read_source
from companion.errors import Aborted, Collided, CompanionError
from companion.ground.operations import MonitorPage
from companion.mission.model import Mission
from companion.mission.world_files import worlds_beside
from companion.run_sources.only_run import OnlyRun
from companion.skills.runner import FunctionRunner

if TYPE_CHECKING:
    from companion.motion.grid import OccupancyGrid
    from sitl.harness import LockstepFlight as LockstepFlight
    from sitl.simulation import Simulation as Simulation
    from sitl.world.scenario import Scenario as Scenario
    from sitl.world.varied_scenario import VariedScenario as VariedScenario
    from sitl.world.vary import Factor as Factor

World: TypeAlias = "tuple[Scenario, OccupancyGrid | None]"
"""A scenario and its map; None is a world without walls."""


@dataclass(frozen=True, eq=False, repr=False)
class SimulationResult(FlightResult):
    """The result of a simulated flight; its trajectory is where the vehicle truly was.

    Attributes:
        scenario_events: time (seconds) and text of each scenario event that has happened.
        collisions: number of collisions with walls and obstacles, also after the end; any is a
            failure with exit code 5, whatever the result of the task.
    """

    scenario_events: tuple[tuple[float, str], ...]
    collisions: int


def simulate(
    mission: Mission,
    scenario: Given | None = None,
    *,
    seed: int = 0,
    folder: Path | str | None = None,
    on_event: OnEvent | None = None,
    laps: int | None = None,
    limit_s: float | None = None,
    timeout_s: float = 30.0,
) -> SimulationResult:
    """Flies a mission in the bundled simulator as fast as possible, without writing any files.

    Equal arguments give equal flights.

    >>> from companion import load_mission, simulate
    >>> run = simulate(load_mission("missions/surveillance.yaml"), seed=7)
    >>> run
    <SimulationResult of surveillance: exit code 0>
    >>> run.events[-1].event
    TaskSatisfied(exit_code=0)
    >>> run.trajectory.positions.shape == (len(run.trajectory.times_s), 3)
    True

    Args:
        mission: the mission to fly.
        scenario: the world: a path, a YAML text, or data (docs/scenario.md). A text, or data,
            without a map uses the mission's map. By default NAME.sim.yaml beside a mission file
            NAME.yaml, if it exists; otherwise the mission's own map, without wind and events.
        seed: the seed of wind, sensors and the estimate.
        folder: where to write a run folder; None writes none.
        on_event: called with each event that is shown to people.
        laps: after this many laps the vehicle is called home; None means no limit.
        limit_s: likewise, simulated seconds since arming was due.
        timeout_s: simulated seconds to wait for a vehicle.

    Raises:
        MissionError: the scenario cannot be read, or does not fit the mission.
        LibraryMissing: jsbsim is not installed.
        CompanionError: it is no mission, or another argument has a wrong type or value.
    """
    check_flight_arguments(mission, folder, on_event, laps, limit_s, timeout_s)
    check_kind(seed, int, "a whole number as seed")
    world = world_of(mission, scenario)
    limit = FlightLimit(laps, limit_s)
    flying = flight_of(mission, world, seed, folder=folder, on_event=on_event, limit=limit)
    with flying as (flight, recorder):
        flight.fly(timeout_s)
    return SimulationResult(
        mission=mission,
        events=tuple(recorder.events),
        trajectory=FlownTrajectory.of(flight.truth),
        failure=verdict(flight.companion.failure, flight.simulation.is_damaged),
        folder=Path(folder) if folder is not None else None,
        scenario_events=tuple(flight.simulation.event_log),
        collisions=flight.simulation.collisions,
    )


@contextmanager
def flight_of(
    mission: Mission,
    world: World,
    seed: int = 0,
    *,
    folder: Path | str | None = None,
    on_event: OnEvent | None = None,
    limit: FlightLimit = NO_LIMIT,
) -> Iterator[tuple[LockstepFlight, Recording]]:
    """A flight of `simulate` before its first tick, with its recording."""
    with (
        recording(mission, folder, on_event) as recorder,
        closing(FunctionRunner(Path(folder) if folder else None, is_lockstep=True)) as functions,
    ):
        only = OnlyRun(mission, recorder, functions=functions)
        keeps_packets = folder is not None
        yield lockstep(only, world, seed=seed, limit=limit, keeps_packets=keeps_packets), recorder


def lockstep(
    run: OnlyRun,
    world: World,
    *,
    seed: int = 0,
    instance: int = 0,
    page: MonitorPage | None = None,
    limit: FlightLimit = NO_LIMIT,
    keeps_packets: bool = True,
) -> LockstepFlight:
    """A flight of `simulate` before its first tick, to be flown tick by tick.

    Args:
        run: the mission with its planner and recorder.
        world: from `world_of`.
        seed: as for `simulate`.
        instance: the vehicle's system id is 1 + instance.
        page: the monitor page, if there is one.
        limit: when the vehicle is called home.
        keeps_packets: whether the recorder keeps datagrams; if not, messages that the companion
            does not read are not packed. The flight is the same.
    """
    from sitl.harness import LockstepFlight
    from sitl.link.routing import LinkName
    from sitl.simulation import Simulation

    scenario, grid = world
    companion = Companion(run, SortieTerms(limit=limit), page=page)
    links, is_all_read = frozenset({LinkName.OFFBOARD}), keeps_packets or scenario.disturbs_links
    simulation = Simulation(
        scenario,
        grid,
        seed=seed,
        instance=instance,
        links=links,
        reader=None if is_all_read else companion.wire,
    )
    return LockstepFlight(companion, simulation)


def verdict(failure: CompanionError | None, is_damaged: bool) -> CompanionError | None:
    """The failure of a simulated flight, given its own; a collision is always one.

    >>> verdict(None, is_damaged=True).exit_code
    5
    """
    if not is_damaged:
        return failure
    return Collided(str(failure) if isinstance(failure, Aborted) else "")


def scenario_beside(mission: Mission) -> Path | None:
    """The scenario NAME.sim.yaml beside a mission file NAME.yaml; None if there is none."""
    beside = worlds_beside(Path(mission.path)) if mission.path else []
    return next((path for path in beside if path.exists()), None)


def world_in_words(mission: Mission, scenario: Path | None) -> str:
    """The world in which a mission is flown, in words for the terminal.

    Args:
        mission: the mission to fly.
        scenario: its file; None for the world of a mission that has no scenario.
    """
    if scenario is not None:
        return str(scenario)
    is_field = mission.grid.is_open and not mission.walls
    alone = "an open field" if is_field else "the mission's own map"
    beside = worlds_beside(Path(mission.path))[:1] if mission.path else []
    missing = "".join(f" (there is no {path.name} beside it)" for path in beside)
    return f"{alone}, without wind{missing}"


def world_alone(mission: Mission) -> dict[str, object]:
    """The scenario of a mission that has none: its own map, without events."""
    north_m, east_m, _ = mission.home.position
    world: dict[str, object] = {"version": 1, "start": {"east_m": east_m, "north_m": north_m}}
    if (home := mission.anchor) is not None:
        world["home"] = asdict(home)
    grid, walls = mission.grid, [wall.as_entry() for wall in mission.walls]
    if mission.map_file:
        return world | {"map": str(Path(mission.map_file).resolve())}
    if grid.is_open and not walls:
        return world
    (south, west), _, (north, east), _ = grid.corners
    area = {} if grid.is_open else {"east_m": [west, east], "north_m": [south, north]}
    return world | {"map": {**area, "cell_m": grid.cell_m, "walls": walls}}


def world_of(mission: Mission, scenario: Given | None = None) -> World:
    """The scenario that `simulate` takes, and its map.

    Raises:
        MissionError: the scenario cannot be read, or does not fit the mission.
        LibraryMissing: jsbsim is not installed.
    """
    from sitl.installed import demand_jsbsim

    demand_jsbsim()
    from sitl.world.scenario import PX4_HOME, read_scenario

    source, grid = _scenario_source(mission, scenario)
    return read_scenario(source, mission.anchor or PX4_HOME, grid)


def varied_world_of(mission: Mission, scenario: Given | None = None) -> VariedScenario:
    """The same scenario with its factors; it makes the world of any row of a campaign.

    Raises:
        MissionError: the scenario cannot be read, or does not fit the mission.
        LibraryMissing: jsbsim is not installed.
    """
    from sitl.installed import demand_jsbsim

    demand_jsbsim()
    from sitl.world.scenario import PX4_HOME
    from sitl.world.varied_scenario import read_varied

    source, grid = _scenario_source(mission, scenario)
    return read_varied(source, mission.anchor or PX4_HOME, grid)


def _scenario_source(
    mission: Mission, scenario: Given | None
) -> tuple[Source, OccupancyGrid | None]:
    """The source of the scenario, and the map for a scenario that names none."""
    if scenario is None:
        scenario = scenario_beside(mission) or world_alone(mission) | {"map": None}  # it is at hand
    source = read_source(scenario, "scenario")
    return source, None if source.path else mission.grid
