"""The commands that fly: run and sim."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated

import typer

from companion.cli.arguments import (
    DEFAULT_LOG_DIR,
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
from companion.cli.terminal import Terminal, undisturbed
from companion.errors import CompanionError, MissionError
from companion.planning.objective import Encoding

if TYPE_CHECKING:
    from companion.acting.flight_limit import FlightLimit
    from companion.app import Companion
    from companion.flight_events.event import Stamped
    from companion.mission.model import Mission
    from companion.planning.engine_port import Engine
    from companion.record.run_folder import RunFolder
    from companion.vehicle.link import Endpoint

OFFBOARD_PORT = 14540
GROUND_STATION_PORT = 14550
UPLOADS = "uploads"
"""Among the run folders: what ground stations have sent."""


def run(
    mission: Annotated[
        Path | None,
        typer.Argument(metavar="MISSION", help="The mission's YAML file; without: uploads."),
    ] = None,
    connect: Annotated[
        str, typer.Option(envvar="COMPANION_CONNECT", help="udpin://HOST:PORT or udpout://...")
    ] = f"udpin://0.0.0.0:{OFFBOARD_PORT}",
    accept_weak_failsafes: Annotated[
        bool, typer.Option(help="Fly although the autopilot's own failsafes are weak.")
    ] = False,
    wait: Annotated[
        bool,
        typer.Option("--wait", help="Fly when a ground station says so, and again and again."),
    ] = False,
    laps: Laps = None,
    limit_s: LimitS = None,
    engine: EngineOption = BUILT_IN,
    encoding: EncodingOption = Encoding.V4,
    engine_timeout: EngineTimeout = ENGINE_TIMEOUT_S,
    timeout: Timeout = 30.0,
    log_dir: LogDir = DEFAULT_LOG_DIR,
    monitor: Monitor = None,
    verbose: Verbose = False,
) -> None:
    """Flies a mission on a vehicle: PX4, or a simulator that was started separately.

    With --wait, or without MISSION, it waits on the ground for a ground station's
    MAV_CMD_MISSION_START, flies, lands, and waits again, until it is stopped.
    """
    from companion.acting.flight_limit import FlightLimit
    from companion.app import Companion
    from companion.vehicle.link import parse_url

    loaded, endpoint = load(mission) if mission else None, parse_url(connect)
    limit, address = FlightLimit(laps, limit_s), monitor or DEFAULT_ADDRESS
    planner = engine_of(engine, encoding, engine_timeout)
    if loaded is None or wait:
        _host(loaded, endpoint, accept_weak_failsafes, log_dir, address, limit, planner)
        return
    terminal = Terminal()
    with (
        closing(terminal),
        _recorded(loaded, log_dir, terminal) as folder,
        monitored(address, terminal.say) as page,
    ):
        page.show(folder.folder)
        companion = Companion(
            loaded, folder, accept_weak_failsafes, page=page, limit=limit, engine=planner
        )
        _fly(companion, endpoint, terminal, speed=1.0, timeout_s=timeout)
        _raise(companion.failure)


def sim(
    mission: MissionFile,
    scenario: Annotated[
        Path | None,
        typer.Option(help="What happens in the world. [default: MISSION's name with .sim.yaml]"),
    ] = None,
    speed: Annotated[
        str, typer.Option(help="Times real time, or max: lockstep in one process.")
    ] = "1",
    seed: Annotated[int, typer.Option(help="Seed of wind and sensors.", min=0)] = 0,
    instance: Instance = 0,
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
    from companion.api.simulating import lockstep, verdict, world_of
    from companion.app import Companion
    from companion.simulator import simulator
    from companion.vehicle.link import Endpoint

    factor, limit = _speed(speed), FlightLimit(laps, limit_s)
    planner = engine_of(engine, encoding, engine_timeout, None if factor else engine_duration)
    loaded = load(mission)
    world = world_of(loaded, path := scenario or _scenario_beside(mission))
    address = monitor or ("off" if factor is None else DEFAULT_ADDRESS)
    terminal = Terminal()
    with (
        closing(terminal),
        _recorded(loaded, log_dir, terminal) as folder,
        monitored(address, terminal.say) as page,
    ):
        page.show(folder.folder)
        if factor is None:
            made = partial(lockstep, seed=seed, instance=instance, limit=limit, engine=planner)
            flight = made(loaded, world, folder, page=page)
            with _stoppable(flight.companion, terminal), undisturbed(flight.companion.hang_up):
                flight.fly(timeout)
            _raise(verdict(flight.companion.failure, flight.simulation.is_damaged))
            return
        companion = Companion(loaded, folder, page=page, limit=limit, engine=planner)
        options = ["--scenario", path, "--speed", factor, "--seed", seed, "--instance", instance]
        port = f"ground station on UDP port {GROUND_STATION_PORT + instance}"
        terminal.say(f"vehicle    simulated, {factor:g} x real time; {port}")
        here = Endpoint(True, "127.0.0.1", OFFBOARD_PORT + instance)
        with simulator([str(o) for o in options], folder.folder / "sitl.log") as child:
            _fly(companion, here, terminal, factor, timeout * factor)
        _raise(verdict(companion.failure, child.is_damaged))


def _scenario_beside(mission: Path) -> Path:
    """The scenario of a mission file."""
    path = mission.with_suffix(".sim.yaml")
    if not path.exists():
        raise MissionError(f"there is no scenario {path}", hint="name one with --scenario")
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


@contextmanager
def _recorded(mission: Mission, log_dir: Path, terminal: Terminal) -> Iterator[RunFolder]:
    """A run folder, announced at the start and at the end."""

    from companion.flight_events.sortie import RunFailed

    def tell(stamped: Stamped) -> None:
        if not isinstance(stamped.event, RunFailed):  # a failure is printed once, by `main`
            terminal.say(_line(stamped))

    folder = _open_folder(mission, log_dir, tell, terminal)
    try:
        yield folder
    finally:
        _close_folder(folder, terminal)


def _open_folder(
    mission: Mission, log_dir: Path, tell: Callable[[Stamped], None], terminal: Terminal
) -> RunFolder:
    from companion.record.run_folder import RunFolder

    now_s = time.time()
    stamp = time.strftime("%Y-%m-%dT%H%M%S", time.localtime(now_s))
    path = log_dir.expanduser() / f"{stamp}-{mission.name}"
    number = 1
    while path.exists():
        number += 1
        path = path.with_name(f"{stamp}-{mission.name}-{number}")
    terminal.say(f"mission    {mission.name}")
    folder = RunFolder(path, mission, now_s, tell)
    terminal.say(f"run        {path}")
    return folder


def _close_folder(folder: RunFolder, terminal: Terminal) -> None:
    folder.close()
    terminal.say(f"results    {folder.folder}")


def _host(
    mission: Mission | None,
    endpoint: Endpoint,
    accepts_weak: bool,
    log_dir: Path,
    address: str,
    limit: FlightLimit,
    engine: Engine | None,
) -> None:
    """Waits for ground stations to start sorties, until it is stopped."""
    from companion.app import Companion
    from companion.cli.hosting import SortieHost
    from companion.ground.uploads import Uploads

    terminal = Terminal()

    def tell(stamped: Stamped) -> None:
        terminal.say(_line(stamped))

    def close_folder(folder: RunFolder) -> None:
        _close_folder(folder, terminal)

    with closing(terminal), monitored(address, terminal.say) as page:

        def open_folder(mission: Mission) -> RunFolder:
            folder = _open_folder(mission, log_dir, tell, terminal)
            page.show(folder.folder)
            return folder

        uploads = Uploads(log_dir.expanduser() / UPLOADS)
        host = SortieHost(open_folder, close_folder, tell, uploads, engine)
        companion = Companion(mission, None, accepts_weak, host, page, limit)
        try:
            what = f"to fly {mission.name}" if mission else "and a mission"
            terminal.say(f"hosting    waits for MAV_CMD_MISSION_START {what}; Ctrl-C ends it")
            _fly(companion, endpoint, terminal, speed=1.0, timeout_s=0.0)
        finally:
            host.close()
            uploads.close()


def _line(stamped: Stamped) -> str:
    """An event as a line of the terminal."""
    minutes, seconds = divmod(stamped.time_s, 60)
    return f" {int(minutes):02d}:{seconds:04.1f}  {stamped.event.text}"


def _fly(
    companion: Companion, endpoint: Endpoint, terminal: Terminal, speed: float, timeout_s: float
) -> None:
    from companion.clock import ScaledClock
    from companion.driving import fly
    from companion.vehicle.link import UdpLink

    link = UdpLink(endpoint)
    try:
        terminal.say(f"waiting    for a vehicle on {endpoint}")
        with _stoppable(companion, terminal), undisturbed(companion.hang_up):
            fly(companion, link, ScaledClock(speed), timeout_s)
    finally:
        link.close()


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
