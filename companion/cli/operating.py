"""The commands of an operator on the ground: upload and watch."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import AsyncGenerator, AsyncIterator, Mapping
from contextlib import ExitStack, asynccontextmanager
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Annotated, Any

import typer

from companion.cli.arguments import MissionFile, SigningKeyFile, UnsignedVehicle, signing_of
from companion.cli.log_lines import Verbose
from companion.errors import LinkError, LinkTimeout, MissionError, printable

if TYPE_CHECKING:
    from companion.ground.station import Heard, Station
    from companion.mavlink.signing import Signing
    from companion.vehicle.endpoints import Endpoint

Connect = Annotated[
    str,
    typer.Option(
        envvar="COMPANION_GROUND_CONNECT",
        metavar="URL",
        help="The link to the vehicle: udpin://HOST:PORT, where the vehicle sends to a ground "
        "station; udpout://HOST:PORT; tcpout://HOST:PORT; or serial://DEVICE:BAUD, for example "
        "of a telemetry radio.",
    ),
]
System = Annotated[
    int | None,
    typer.Option(help="System id of the vehicle.", min=1, max=255, show_default="the only one"),
]
Timeout = Annotated[float, typer.Option(help="Wait this many seconds for the companion.", min=0.1)]
GROUND_STATION = "udpin://0.0.0.0:14550"
VERDICT_S = 60.0
"""A check takes at most 30 s, and may have to wait for another one."""
SILENT_S = 10.0
LAST_WORDS_S = 0.5
"""Time after the end for texts that are still under way."""
SILENCE = f"the companion was not heard for {SILENT_S:.0f} s"
MISSION_START = 300  # MAV_CMD_MISSION_START


def upload(
    mission: MissionFile,
    connect: Connect = GROUND_STATION,
    start: Annotated[
        bool, typer.Option(help="Start the mission when it has been accepted.")
    ] = False,
    system: System = None,
    signing_key: SigningKeyFile = None,
    unsigned_vehicle: UnsignedVehicle = False,
    timeout: Timeout = 30.0,
    verbose: Verbose = False,
) -> None:
    """Sends a mission and its files to a running companion (`companion run`), which checks it.

    Exit codes: 0, the mission is accepted; 2, it is refused; 4, there is no link.
    """
    from companion.cli.upload_files import remote_paths
    from companion.mission.files import files_of
    from companion.vehicle.endpoints import parse_url

    files = files_of(mission, mission.parent)
    remotes = remote_paths(files, mission.parent)
    endpoint = parse_url(connect)
    with signing_of(signing_key, f"upload-{endpoint.name}", unsigned_vehicle) as signing:
        asyncio.run(_upload(remotes, endpoint, system, signing, start, timeout))


def watch(
    connect: Connect = GROUND_STATION,
    system: System = None,
    signing_key: SigningKeyFile = None,
    unsigned_vehicle: UnsignedVehicle = False,
    timeout: Timeout = 30.0,
    verbose: Verbose = False,
) -> None:
    """Prints the messages of a companion until its run ends; exits with that run's exit code."""
    from companion.vehicle.endpoints import parse_url

    endpoint = parse_url(connect)
    with signing_of(signing_key, f"watch-{endpoint.name}", unsigned_vehicle) as signing:
        try:
            code = asyncio.run(_watch(endpoint, system, signing, timeout))
        except KeyboardInterrupt:
            code = 0
    raise typer.Exit(code)


@asynccontextmanager
async def _station(
    endpoint: Endpoint, number: int | None, signing: Signing | None, timeout_s: float
) -> AsyncIterator[Station]:
    """A ground station on a link; with a key, by a relay that signs.

    The library for ground stations would take a port away from the program that uses it.
    """
    from companion.cli.signing_relay import relayed
    from companion.ground.station import connected
    from companion.vehicle.transport import check_port

    typer.echo(f"waiting    for a companion on {endpoint}")
    if signing is None:
        check_port(endpoint)
        async with connected(str(endpoint), number, timeout_s) as station:
            yield station
        return
    with relayed(endpoint, signing) as relay:
        try:
            async with connected(relay.url, number, timeout_s) as station:
                yield station
        except LinkTimeout as error:
            raise LinkTimeout(f"{error}\n    {endpoint}: {relay.account()}") from error


async def _upload(
    remotes: Mapping[Path, PurePosixPath],
    endpoint: Endpoint,
    number: int | None,
    signing: Signing | None,
    starts: bool,
    timeout_s: float,
) -> None:
    from companion.mavlink.ftp_frames import crc32

    *others, mission = remotes
    async with _station(endpoint, number, signing, timeout_s) as station:
        before = await station.verdict()
        for file in others:
            await _send(station, file, remotes[file], is_needed=False)
        await _send(station, mission, remotes[mission], is_needed=True)
        verdict = await station.new_verdict(
            int(before["number"]) if before else 0, crc32(mission.read_bytes()), VERDICT_S
        )
        if not verdict["is_accepted"]:
            raise MissionError(f"the companion refuses the mission\n{verdict['details']}")
        typer.echo(f"verdict    {printable(verdict['text'])}")
        for notice in verdict.get("notices", ()):
            typer.echo(f"notice     {printable(notice)}")
        if starts:
            await _start(station)


async def _send(station: Station, file: Path, remote: PurePosixPath, is_needed: bool) -> None:
    """Sends a file, unless it is there already and need not be sent again."""
    if not is_needed and await station.has(file, remote):
        typer.echo(f"there      {remote}")
        return
    with ExitStack() as stack:
        await station.put(file, remote, _progress(stack, str(remote)))
    typer.echo(f"sent       {remote}, {file.stat().st_size} bytes")


def _progress(stack: ExitStack, what: str) -> Any:
    """A progress bar on a terminal, while the stack lasts."""
    from rich.progress import Progress

    bar = stack.enter_context(Progress(transient=True, disable=not _is_terminal()))
    task = bar.add_task(what, total=None)
    return lambda sent, total: bar.update(task, completed=sent, total=total)


def _is_terminal() -> bool:
    from rich.console import Console

    return Console().is_terminal


async def _start(station: Station) -> None:
    from companion.mavlink.commands import result_name

    result = result_name(await station.command(MISSION_START))
    if result != "ACCEPTED":
        raise LinkError(f"the companion does not start the mission: {result}")
    typer.echo("started")


async def _watch(
    endpoint: Endpoint, number: int | None, signing: Signing | None, timeout_s: float
) -> int:
    from rich.console import Console
    from rich.live import Live

    from companion.ground.station import COMPANION
    from companion.ground.watching import NAMES, WatchedFlight

    async with _station(endpoint, number, signing, timeout_s) as station:
        seen, messages = WatchedFlight(time.monotonic()), station.messages(NAMES)
        heard = await _next(messages)
        typer.echo(f"watching   component {COMPANION} of system {station.system}")
        console = Console(highlight=False, markup=False, soft_wrap=True)
        with ExitStack() as stack:
            live = stack.enter_context(Live(console=console)) if console.is_terminal else None
            ends_s = math.inf
            while (now_s := time.monotonic()) < ends_s:
                for line in seen.take(now_s, *heard):
                    console.print(f"{time.strftime('%H:%M:%S')}  {line}")
                if live:
                    live.update(seen.status)
                if now_s - seen.heard_s > SILENT_S:
                    raise LinkTimeout(SILENCE)
                if seen.exit_code is not None:
                    ends_s = min(ends_s, now_s + LAST_WORDS_S)
                heard = await _next(messages)
            await messages.aclose()
    assert seen.exit_code is not None
    return seen.exit_code


async def _next(messages: AsyncGenerator[Heard]) -> Heard:
    try:
        return await asyncio.wait_for(anext(messages), SILENT_S)
    except TimeoutError:
        raise LinkTimeout(SILENCE) from None
