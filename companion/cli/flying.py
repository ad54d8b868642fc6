"""The commands that fly: run and sim."""

from __future__ import annotations

import json
import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated

import typer

from companion.acting.arming_terms import ArmingTerms, FencePolicy
from companion.cli.arguments import (
    DEFAULT_LOG_DIR,
    AutopilotFence,
    Events,
    GroundPort,
    Instance,
    Laps,
    LimitS,
    LinkUrl,
    LogDir,
    MissionFile,
    Resume,
    SigningKeyFile,
    Timeout,
    UnsignedVehicle,
    WeakFailsafes,
    load,
    signing_of,
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
from companion.cli.recording import close_run, flown_s, line, open_run, recorded
from companion.cli.resuming import CutOffRun, cut_off_run
from companion.cli.terminal import Terminal, undisturbed
from companion.errors import CompanionError
from companion.planning.objective import Encoding

if TYPE_CHECKING:
    from companion.app import Companion
    from companion.flight_events.event import Stamped
    from companion.mission.model import Mission
    from companion.planning.engine_port import Engine
    from companion.record.run_folder import RunFolder
    from companion.vehicle.link import Link

ScenarioFile = Annotated[
    Path | None,
    typer.Option(
        help="What happens in the world. [default: MISSION's name with .sim.yaml, or nothing]"
    ),
]
Speed = Annotated[str, typer.Option(help="Times real time, or max: lockstep in one process.")]
OFFBOARD_PORT = 14540
GROUND_STATION_PORT = 14550
UPLOADS = "uploads"
"""Among the run folders: what ground stations have sent."""


def run(
    mission: Annotated[
        Path | None,
        typer.Argument(metavar="MISSION", help="The mission's YAML file; without: uploads."),
    ] = None,
    connect: LinkUrl = f"udpin://0.0.0.0:{OFFBOARD_PORT}",
    accept_weak_failsafes: WeakFailsafes = False,
    autopilot_fence: AutopilotFence = FencePolicy.UPLOAD,
    wait: Annotated[
        bool,
        typer.Option("--wait", help="Fly when a ground station says so, and again and again."),
    ] = False,
    resume: Resume = False,
    events: Events = None,
    laps: Laps = None,
    limit_s: LimitS = None,
    engine: EngineOption = BUILT_IN,
    encoding: EncodingOption = Encoding.V4,
    engine_timeout: EngineTimeout = ENGINE_TIMEOUT_S,
    signing_key: SigningKeyFile = None,
    unsigned_vehicle: UnsignedVehicle = False,
    timeout: Timeout = 30.0,
    log_dir: LogDir = DEFAULT_LOG_DIR,
    monitor: Monitor = None,
    verbose: Verbose = False,
) -> None:
    """Flies a mission on a vehicle: PX4, or a simulator that was started separately.

    With --wait, or without MISSION, it waits on the ground for a ground station's
    MAV_CMD_MISSION_START, flies, lands, and waits again, until it is stopped.

    With --resume it takes control back by itself where the autopilot holds because it no longer
    heard us: after a gap in the link; and, started again with the same mission, after it was cut
    off in flight. A vehicle that has landed meanwhile is not armed again.
    """
    from companion.acting.flight_limit import FlightLimit
    from companion.app import Companion
    from companion.record.own_fence_file import own_fences_in
    from companion.vehicle.endpoints import parse_url
    from companion.vehicle.link import Link

    loaded, endpoint = load(mission) if mission else None, parse_url(connect)
    limit, address = FlightLimit(laps, limit_s), monitor or DEFAULT_ADDRESS
    planner = engine_of(engine, encoding, engine_timeout)
    cut_off = cut_off_run(log_dir, loaded) if resume else None
    companion_of = partial(
        Companion,
        terms=ArmingTerms(accept_weak_failsafes, autopilot_fence),
        own_fences=own_fences_in(log_dir),
        limit=limit,
        resumes=resume,
        journalled=cut_off.journalled if cut_off else None,
    )
    with signing_of(signing_key, f"run-{endpoint.name}", unsigned_vehicle) as signing:
        fly = partial(_fly, link_of=partial(Link, endpoint, signing), events=events)
        if loaded is None or wait:
            _host(companion_of, loaded, fly, log_dir, address, planner, cut_off)
        else:
            _fly_once(companion_of, loaded, fly, log_dir, address, planner, cut_off, timeout)


def sim(
    mission: MissionFile,
    scenario: ScenarioFile = None,
    speed: Speed = "1",
    seed: Annotated[int, typer.Option(help="Seed of wind and sensors.", min=0)] = 0,
    instance: Instance = 0,
    ground_port: GroundPort = GROUND_STATION_PORT,
    events: Events = None,
    laps: Laps = None,
    limit_s: LimitS = None,
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
    from companion.api import simulating
    from companion.app import Companion
    from companion.simulator import simulator
    from companion.skills.runner import FunctionRunner
    from companion.vehicle.endpoints import UdpPort
    from companion.vehicle.link import Link

    factor, limit = _speed(speed), FlightLimit(laps, limit_s)
    planner = engine_of(engine, encoding, engine_timeout, None if factor else engine_duration)
    loaded, terminal = load(mission), Terminal()
    world = simulating.world_of(loaded, path := scenario or simulating.scenario_beside(loaded))
    with (
        closing(terminal),
        recorded(loaded, log_dir, terminal) as folder,
        monitored(monitor or ("off" if factor is None else DEFAULT_ADDRESS), terminal.say) as page,
        closing(FunctionRunner(folder.folder, is_lockstep=factor is None)) as functions,
    ):
        page.show(folder.folder)
        if factor is None:
            made = partial(simulating.lockstep, seed=seed, instance=instance, limit=limit)
            flight = made(loaded, world, folder, page=page, engine=planner, functions=functions)
            with _stoppable(flight.companion, terminal), undisturbed(flight.companion.hang_up):
                flight.fly(timeout)
            _raise(simulating.verdict(flight.companion.failure, flight.simulation.is_damaged))
            return
        companion = Companion(
            loaded, folder, page=page, limit=limit, engine=planner, functions=functions
        )
        path = path or _written(simulating.world_alone(loaded), folder.folder / "world.sim.yaml")
        told = f"simulated, {factor:g} x real time; ground station on UDP port {ground_port}"
        terminal.say(f"vehicle    {told}")
        options = ["--scenario", path, "--seed", seed, "--ground-port", ground_port]
        options += ["--speed", factor, "--instance", instance, "--home", world[0].home]
        link_of = partial(Link, UdpPort("127.0.0.1", OFFBOARD_PORT + instance))
        with simulator(options, folder.folder / "sitl.log") as child:
            _fly(companion, terminal, factor, timeout * factor, link_of=link_of, events=events)
        _raise(simulating.verdict(companion.failure, child.is_damaged))


def _written(scenario: dict[str, object], path: Path) -> Path:
    """The file of a scenario that is given as data; JSON is YAML, too."""
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


def _fly_once(
    companion_of: Callable[..., Companion],
    mission: Mission,
    fly: Callable[..., None],
    log_dir: Path,
    address: str,
    engine: Engine | None,
    cut_off: CutOffRun | None,
    timeout_s: float,
) -> None:
    """Flies one mission, or goes on with one; raises what it has failed of."""
    from companion.skills.runner import FunctionRunner

    terminal = Terminal()
    with (
        closing(terminal),
        recorded(mission, log_dir, terminal, True, cut_off) as folder,
        monitored(address, terminal.say) as page,
        closing(FunctionRunner(folder.folder)) as functions,
    ):
        page.show(folder.folder)
        companion = companion_of(mission, folder, page=page, engine=engine, functions=functions)
        fly(companion, terminal, 1.0, timeout_s, flown_s(cut_off))
        _raise(companion.failure)


def _host(
    companion_of: Callable[..., Companion],
    mission: Mission | None,
    fly: Callable[..., None],
    log_dir: Path,
    address: str,
    engine: Engine | None,
    cut_off: CutOffRun | None,
) -> None:
    """Waits for ground stations to start sorties, until it is stopped; first goes on with one."""
    from companion.cli.hosting import SortieHost
    from companion.ground.checking import CheckChildren
    from companion.ground.uploads import Uploads
    from companion.mission.installed_calls import functions_of
    from companion.skills.installed import read_all
    from companion.skills.runner import FunctionRunner

    terminal = Terminal()

    def tell(stamped: Stamped) -> None:
        terminal.say(line(stamped))

    def close_folder(folder: RunFolder) -> None:
        close_run(folder, terminal)

    with (
        closing(terminal),
        closing(FunctionRunner()) as functions,
        monitored(address, terminal.say) as page,
    ):

        def open_folder(mission: Mission, cut_off: CutOffRun | None = None) -> RunFolder:
            folder = open_run(mission, log_dir, tell, terminal, True, cut_off)
            page.show(folder.folder)
            return folder

        installed = read_all()
        children = CheckChildren(installed)
        uploads = Uploads(log_dir.expanduser() / UPLOADS, children.begin)
        host = SortieHost(open_folder, close_folder, tell, uploads, engine, functions, installed)
        recorder = host.resume_run(open_folder(cut_off.mission, cut_off)) if cut_off else None
        mission = cut_off.mission if cut_off else mission
        functions.prepare(functions_of(mission) if mission else ())
        companion = companion_of(mission, recorder, host=host, page=page, engine=engine)
        try:
            what = f"to fly {mission.name}" if mission else "and a mission"
            terminal.say(f"hosting    waits for MAV_CMD_MISSION_START {what}; Ctrl-C ends it")
            fly(companion, terminal, 1.0, 0.0, flown_s(cut_off))
        finally:
            host.close()
            uploads.close()
            children.close()


def _fly(
    companion: Companion,
    terminal: Terminal,
    speed: float,
    timeout_s: float,
    begin_s: float = 0.0,
    *,
    link_of: Callable[[], Link],
    events: str | None,
) -> None:
    from companion.clock import ScaledClock
    from companion.driving import fly
    from companion.vehicle.report_port import reports_at
    from companion.watchdog import Watchdog

    with (
        reports_at(events) as reports,
        closing(link_of()) as link,
        closing(Watchdog(os.environ)) as watchdog,
    ):
        terminal.say(f"waiting    for a vehicle on {link.endpoint}")
        clock = ScaledClock(speed, begin_s=begin_s)
        with _stoppable(companion, terminal), undisturbed(companion.hang_up):
            fly(companion, link, clock, timeout_s, lambda: watchdog.beat(time.monotonic()), reports)


def _raise(failure: CompanionError | None) -> None:
    if failure is not None:
        raise failure


@contextmanager
def _stoppable(companion: Companion, terminal: Terminal) -> Iterator[None]:
    """The first Ctrl-C (or SIGTERM) holds, lands and exits; the second exits at once."""

    def stop(number: int, _: FrameType | None) -> None:
        signal.signal(number, signal.default_int_handler)  # before the promise below is read
        companion.stop()
        terminal.say("stopping: hold, land, exit; once more to exit at once", is_error=True)

    before = {n: signal.signal(n, stop) for n in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
