"""The bundled simulator in this process: the world of a mission, and flights in lockstep with it.

Only this module of the companion imports the simulator.
"""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from companion.app import Companion
from companion.documents import Given, Source, read_source
from companion.errors import Aborted, Collided, CompanionError
from companion.geometry import GlobalOrigin
from companion.mission.model import Mission
from companion.mission.world_files import worlds_beside

if TYPE_CHECKING:
    from companion.motion.grid import OccupancyGrid
    from sitl.harness import LockstepFlight as LockstepFlight
    from sitl.simulation import Simulation as Simulation
    from sitl.world.scenario import Scenario as Scenario
    from sitl.world.varied_scenario import VariedScenario as VariedScenario
    from sitl.world.vary import Factor as Factor

World: TypeAlias = "tuple[Scenario, OccupancyGrid | None]"
"""A scenario and its map; None is a world without walls."""


def lockstep(
    companion: Companion,
    world: World,
    *,
    seed: int = 0,
    instance: int = 0,
    keeps_packets: bool = True,
) -> LockstepFlight:
    """A flight in the simulator before its first tick, to be flown tick by tick.

    Args:
        companion: the companion to run.
        world: from `world_of`.
        seed: as for `simulate`.
        instance: the vehicle's system id is 1 + instance.
        keeps_packets: whether the recorder keeps datagrams; if not, messages that the companion
            does not read are not packed. The flight is the same.
    """
    from sitl.harness import LockstepFlight
    from sitl.link.routing import LinkName
    from sitl.simulation import Simulation

    scenario, grid = world
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
    given = _scenario_given(mission, scenario)
    from sitl.world.scenario import read_scenario

    return read_scenario(*given)


def varied_world_of(mission: Mission, scenario: Given | None = None) -> VariedScenario:
    """The same scenario with its factors; it makes the world of any row of a campaign.

    Raises:
        MissionError: the scenario cannot be read, or does not fit the mission.
        LibraryMissing: jsbsim is not installed.
    """
    given = _scenario_given(mission, scenario)
    from sitl.world.varied_scenario import read_varied

    return read_varied(*given)


def _scenario_given(
    mission: Mission, scenario: Given | None
) -> tuple[Source, GlobalOrigin, OccupancyGrid | None]:
    """What a scenario is read from: its source, the earth below it, and the map it need not name.

    Raises:
        LibraryMissing: jsbsim is not installed.
    """
    from sitl.installed import demand_jsbsim

    demand_jsbsim()
    from sitl.world.scenario import PX4_HOME

    if scenario is None:
        scenario = scenario_beside(mission) or world_alone(mission) | {"map": None}  # it is at hand
    source = read_source(scenario, "scenario")
    return source, mission.anchor or PX4_HOME, None if source.path else mission.grid
