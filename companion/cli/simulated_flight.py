"""The command that flies in the bundled simulator: sim."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Annotated

import typer

from companion.cli.arguments import (
    DEFAULT_LOG_DIR,
    Contingencies,
    Events,
    GroundPort,
    Instance,
    Laps,
    LimitS,
    LogDir,
    MissionFile,
    Timeout,
    load,
)
from companion.cli.engine_options import (
    BUILT_IN,
    ENGINE_TIMEOUT_S,
    EncodingOption,
    EngineDuration,
    EngineOption,
    EngineTimeout,
    engine_of,
)
from companion.cli.log_lines import Verbose
from companion.cli.monitoring import DEFAULT_ADDRESS, Monitor, monitored
from companion.cli.real_time import OFFBOARD_PORT, fly_over, raise_failure, stoppable
from companion.cli.recording import recorded
from companion.cli.terminal import Terminal, undisturbed
from companion.planning.objective import Encoding

if TYPE_CHECKING:
    from companion.api.simulating import LockstepFlight

ScenarioFile = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="The scenario file, which says what happens in the world. Without one, the world is "
        "the map of the mission, without wind and events.",
        show_default="MISSION's name with .sim.yaml, if there is such a file",
    ),
]
Speed = Annotated[
    str,
    typer.Option(
        help="Speed as a multiple of real time. max: in lockstep, as fast as possible; equal "
        "seeds give equal flights."
    ),
]
Seed = Annotated[int, typer.Option(help="Seed of all randomness, such as gusts and noise.", min=0)]
GROUND_STATION_PORT = 14550


def sim(
    mission: MissionFile,
    scenario: ScenarioFile = None,
    speed: Speed = "1",
    seed: Seed = 0,
    instance: Instance = 0,
    ground_port: GroundPort = GROUND_STATION_PORT,
    events: Events = None,
    laps: Laps = None,
    limit_s: LimitS = None,
    contingencies: Contingencies = False,
    engine: EngineOption = BUILT_IN,
    encoding: EncodingOption = Encoding.V4,
    engine_timeout: EngineTimeout = ENGINE_TIMEOUT_S,
    engine_duration: EngineDuration = 1.0,
    timeout: Timeout = 30.0,
    log_dir: LogDir = DEFAULT_LOG_DIR,
    monitor: Monitor = None,
    verbose: Verbose = False,
) -> None:
    """Flies a mission in the bundled simulator. QGroundControl connects to it by itself."""
    from companion.acting.flight_limit import FlightLimit
    from companion.acting.sortie_terms import SortieTerms
    from companion.api import simulating
    from companion.app import Companion
    from companion.run_sources.only_run import OnlyRun
    from companion.simulator import simulator
    from companion.skills.runner import FunctionRunner
    from companion.vehicle.endpoints import UdpPort
    from companion.vehicle.link import Link

    factor, limit = _speed(speed), FlightLimit(laps, limit_s)
    loaded, duration_s = load(mission, contingencies), None if factor else engine_duration
    planner = engine_of(engine, encoding, engine_timeout, duration_s, loaded)
    world = simulating.world_of(loaded, path := scenario or simulating.scenario_beside(loaded))
    with (
        closing(Terminal()) as terminal,
        recorded(loaded, log_dir, terminal) as folder,
        monitored(monitor or ("off" if factor is None else DEFAULT_ADDRESS), terminal.say) as page,
        closing(FunctionRunner(folder.folder, is_lockstep=factor is None)) as functions,
        _report_address(events) as reports,
    ):
        terminal.say(f"world      {simulating.world_in_words(loaded, path)}")
        page.show(folder.folder)
        only = OnlyRun(loaded, folder, engine=planner, functions=functions)
        if factor is None:
            made = partial(simulating.lockstep, seed=seed, instance=instance, limit=limit)
            _fly_in_lockstep(made(only, world, page=page), terminal, timeout)
            return
        companion = Companion(only, SortieTerms(limit=limit), page=page)
        path = path or _written(simulating.world_alone(loaded), folder.folder / "world.sim.yaml")
        told = f"simulated, {factor:g} x real time; ground station on UDP port {ground_port}"
        terminal.say(f"vehicle    {told}")
        options = ["--scenario", path, "--seed", seed, "--speed", factor, "--instance", instance]
        options += ["--ground-port", ground_port, "--home", world[0].home, "--reports", reports]
        link_of = partial(Link, UdpPort("127.0.0.1", OFFBOARD_PORT + instance))
        with simulator(options, folder.folder / "sitl.log") as child:
            fly_over(companion, terminal, factor, timeout * factor, link_of=link_of, events=reports)
        raise_failure(simulating.verdict(companion.failure, child.is_damaged))


def _fly_in_lockstep(flight: LockstepFlight, terminal: Terminal, timeout_s: float) -> None:
    """Flies until the flight ends or is stopped; raises its failure."""
    from companion.api.simulating import verdict

    with stoppable(flight.companion, terminal), undisturbed(flight.companion.hang_up):
        flight.fly(timeout_s)
    raise_failure(verdict(flight.companion.failure, flight.simulation.is_damaged))


@contextmanager
def _report_address(given: str | None) -> Iterator[str]:
    """The address for reports of a simulated vehicle's programs: the user's, or an own socket.

    The socket has a folder of its own, because its path must be short.
    """
    with TemporaryDirectory(prefix="companion-") as own:
        yield given or f"unix:{own}/events"


def _written(scenario: dict[str, object], path: Path) -> Path:
    """Writes a file with a scenario that is given as data; JSON is also YAML."""
    path.write_text(json.dumps(scenario), encoding="utf-8")
    return path


def _speed(text: str) -> float | None:
    """The real-time factor; None for `max`."""
    if text == "max":
        return None
    try:
        factor = float(text)
    except ValueError:
        factor = 0.0
    if not 0.0 < factor < 1000.0:
        raise typer.BadParameter(f"{text} is not a positive number or max", param_hint="--speed")
    return factor
