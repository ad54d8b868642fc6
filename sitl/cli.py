"""The simulator's command line: one simulation on PX4's ports, in real or scaled time.

Simulated time runs F times as fast as the monotonic clock, as with PX4's PX4_SIM_SPEED_FACTOR. On a
machine that cannot keep up, simulated time slows down and never jumps. Options default to PX4's
environment variables.
"""

from __future__ import annotations

import os
import select
import signal
import sys
from contextlib import AbstractContextManager, closing, nullcontext
from dataclasses import replace
from importlib import metadata
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated, Any

import typer

from companion.clock import ScaledClock
from companion.errors import Collided, CompanionError, printable
from companion.geometry import GlobalOrigin
from companion.mavlink.key_file import signing_by
from companion.mavlink.signing import Signing, harmless
from companion.motion.grid import OccupancyGrid
from sitl.installed import demand_jsbsim
from sitl.link.report_sender import ReportSender
from sitl.link.routing import LinkName
from sitl.link.server import GROUND_PORT, LOCAL_PORTS, Server
from sitl.world.scenario import PX4_HOME, Scenario, read_scenario

if TYPE_CHECKING:
    from sitl.simulation import Simulation

DISTRIBUTION = "mav-companion"
Reports = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        help="Send the reports of the scenario's programs on board to this address, which is the "
        "--events of the companion: unix:PATH or udpin:HOST:PORT.",
        show_default="nowhere",
    ),
]
PERIOD_S = 0.004  # the loop looks at the clock this often, and at once when a datagram arrives
MAX_JUMP_S = 0.1  # wall time; if the loop is further behind than this, simulated time slows down


class _Stop:
    """Set by SIGINT and SIGTERM and, if the simulator is attended, by the end of standard input."""

    def __init__(self, is_attended: bool) -> None:
        self._is_attended = is_attended
        self._is_set = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._set)

    def _set(self, number: int, frame: FrameType | None) -> None:
        self._is_set = True

    @property
    def is_set(self) -> bool:
        """True once the simulation is to end."""
        if self._is_attended and not self._is_set and select.select([sys.stdin], [], [], 0.0)[0]:
            self._is_set = not os.read(sys.stdin.fileno(), 1024)
        return self._is_set


def parse_home(text: str) -> GlobalOrigin:
    """The home position from "LAT,LON,ALT", in degrees and in metres above sea level.

    Raises:
        typer.BadParameter: the text has another form.
    """
    try:
        latitude, longitude, altitude = (float(part) for part in text.split(","))
    except ValueError:
        raise typer.BadParameter("LAT,LON,ALT in degrees and metres, e.g. 47.4,8.5,488") from None
    if not (abs(latitude) <= 90 and abs(longitude) <= 180 and abs(altitude) < 10_000):
        raise typer.BadParameter("latitude, longitude or altitude is out of range")
    return GlobalOrigin(latitude, longitude, altitude)


def default_home(environment: dict[str, str]) -> GlobalOrigin:
    """PX4_HOME_LAT, PX4_HOME_LON and PX4_HOME_ALT; PX4's own home for those that are not set."""
    latitude, longitude, altitude = (
        environment.get(f"PX4_HOME_{name}", str(default))
        for name, default in (
            ("LAT", PX4_HOME.latitude_deg),
            ("LON", PX4_HOME.longitude_deg),
            ("ALT", PX4_HOME.altitude_m),
        )
    )
    return parse_home(f"{latitude},{longitude},{altitude}")


def _print_version(is_wanted: bool) -> None:
    if is_wanted:
        typer.echo(f"sitl {metadata.version(DISTRIBUTION)}")
        raise typer.Exit


Check = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Check a scenario file and fly nothing.")
]
Version = Annotated[
    bool,
    typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version."),
]
ScenarioFile = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="The scenario. Without it, the world is empty."),
]
Speed = Annotated[
    float,
    typer.Option(envvar="PX4_SIM_SPEED_FACTOR", min=0.01, help="Speed as a multiple of real time."),
]
Instance = Annotated[
    int,
    typer.Option(
        "--instance",
        "-i",
        min=0,
        max=253,
        help="Number of the simulator: added to its system id and its ports, as in PX4.",
    ),
]
GroundPort = Annotated[
    int,
    typer.Option(
        min=1,
        max=65535,
        help="UDP port of the ground station. It is the same for all instances.",
    ),
]
SigningKeyFile = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Sign all messages, and accept only signed ones. `companion key` makes a key.",
    ),
]
Home = Annotated[
    GlobalOrigin | None,
    typer.Option(
        parser=parse_home, metavar="LAT,LON,ALT", help="Where the vehicle stands at the start."
    ),
]


def simulate(
    scenario: ScenarioFile = None,
    speed: Speed = 1.0,
    instance: Instance = 0,
    ground_port: GroundPort = GROUND_PORT,
    home: Home = None,
    seed: Annotated[int, typer.Option(help="Seed of all randomness, such as gusts and noise.")] = 0,
    signing_key: SigningKeyFile = None,
    reports: Reports = None,
    quiet: Annotated[
        bool, typer.Option("--quiet", help="Do not print what happens in the world.")
    ] = False,
    attended: Annotated[
        bool, typer.Option("--attended", help="End when standard input does.", hidden=True)
    ] = False,
    check: Check = None,
    version: Version = False,
) -> None:
    """Simulates one PX4-like vehicle on PX4's UDP ports.

    The simulator sends to a ground station on UDP port 14550, and to a companion
    or MAVSDK on UDP port 14540 + instance. A scenario file says what happens in
    the world: target, obstacles, wind, faults. Each of its events is printed when
    it happens. The exit code is 5 if the vehicle has hit something.
    """
    try:
        if check:
            count = len(read_scenario(check)[0].events)
            typer.echo(f"{check}: a good scenario, {count} event{'' if count == 1 else 's'}")
            return
        world = _world(scenario, home)
        demand_jsbsim()
        with (
            signing_by(signing_key, f"sitl-{instance}", harmless) as signing,
            Server(instance, ground_port) as server,
            _report_sender(reports) as sender,
        ):
            stop = _Stop(attended)
            if _simulate(world, scenario, speed, server, sender, seed, quiet, stop, signing):
                raise typer.Exit(Collided.exit_code)
    except CompanionError as error:
        typer.echo(str(error), err=True)
        raise typer.Exit(error.exit_code) from error


def _world(path: Path | None, home: GlobalOrigin | None) -> tuple[Scenario, OccupancyGrid | None]:
    """The scenario and its map, if it has one; home on the command line overrides the file's."""
    fallback = home or default_home(dict(os.environ))
    if path is None:
        return Scenario(home=fallback), None
    scenario, grid = read_scenario(path, fallback)
    return replace(scenario, home=home) if home else scenario, grid


def _simulate(
    world: tuple[Scenario, OccupancyGrid | None],
    path: Path | None,
    speed: float,
    server: Server,
    sender: ReportSender | None,
    seed: int,
    is_quiet: bool,
    stop: _Stop,
    signing: Signing | None,
) -> bool:
    """Simulates until asked to end and the vehicle is at rest; returns whether it is damaged."""
    from sitl.simulation import Simulation

    instance = server.instance
    simulation = Simulation(*world, seed=seed, instance=instance, signing=signing)
    gcs, offboard = (server.peers[link][1] for link in (LinkName.GCS, LinkName.OFFBOARD))
    typer.echo(f"sitl: vehicle {1 + instance} in {path or 'an empty world'}, {speed:g} x real time")
    typer.echo(
        f"sitl: ground station on UDP {gcs} (local {LOCAL_PORTS[LinkName.GCS] + instance}), "
        f"companion on UDP {offboard} (local {LOCAL_PORTS[LinkName.OFFBOARD] + instance})"
    )
    if sender is None and any("report" in dict(event.effects) for event in world[0].events):
        typer.echo("sitl: reports go nowhere; --reports says where a companion's --events listens")
    sys.stdout.flush()
    clock = ScaledClock(speed, MAX_JUMP_S)
    told = 0
    while not stop.is_set:
        datagrams = server.receive(PERIOD_S)
        server.send(simulation.step(clock.now_s(), datagrams))
        if sender is not None:
            sender.send(simulation.take_reports())
        told = _tell(simulation, told, is_quiet)
        if signing is not None and (refused := signing.news()):
            typer.echo(f"sitl: frames refused: {refused}")
    simulation.settle()
    _tell(simulation, told, is_quiet)
    return simulation.is_damaged


def _report_sender(address: str | None) -> AbstractContextManager[ReportSender | None]:
    """A sender of reports that is open in this context; None without an address."""
    return nullcontext() if address is None else closing(ReportSender(address))


def _tell(simulation: Simulation, told: int, is_quiet: bool) -> int:
    """Prints the events of the world that are new; returns how many are printed so far."""
    for time_s, text in simulation.event_log[told:]:
        if not is_quiet:
            print(f"sitl: {time_s:.2f} s: {printable(text)}", flush=True)
    return len(simulation.event_log)


def main(arguments: list[str] | None = None) -> Any:
    """Entry point of `sitl` and `python -m sitl`."""
    application = typer.Typer(add_completion=False)
    application.command()(simulate)
    return application(args=arguments)
