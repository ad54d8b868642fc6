"""The command that flies in the bundled simulator: sim."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Annotated

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
from companion.cli.monitoring import Monitor
from companion.cli.terminal import Terminal
from companion.flights.monitor_page import PageOptions
from companion.planning.objective import Encoding

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
    from companion.acting.sortie.flight_limit import FlightLimit
    from companion.acting.sortie.terms import SortieTerms
    from companion.flights.options import FlightOptions
    from companion.flights.simulated_flights import SimulatedFlights, SimulatorOptions

    factor, terms = _speed(speed), SortieTerms(limit=FlightLimit(laps, limit_s))
    loaded, duration_s = load(mission, contingencies), None if factor else engine_duration
    planner = engine_of(engine, encoding, engine_timeout, duration_s, loaded)
    with closing(Terminal()) as terminal:
        flights = SimulatedFlights(
            FlightOptions(terms, planner),
            SimulatorOptions(scenario, seed, instance, ground_port),
            timeout_s=timeout,
            log_dir=log_dir.expanduser(),
            page=monitor or PageOptions(is_on=factor is not None),
            front_end=terminal,
        )
        if factor is None:
            failure = flights.fly_in_lockstep(loaded)
        else:
            failure = flights.fly_by_clock(loaded, factor, events)
        if failure is not None:
            raise failure


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
