"""The command that checks this machine before a flight: doctor."""

from __future__ import annotations

import os
import platform
import shutil
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from companion.cli.arguments import DEFAULT_LOG_DIR, Instance, LogDir
from companion.cli.monitoring import DEFAULT_PAGE
from companion.cli.shipped import DISTRIBUTION, folder, names
from companion.cli.simulated_flight import GROUND_STATION_PORT
from companion.vehicle.endpoints import OFFBOARD_PORT

if TYPE_CHECKING:
    from companion.mavlink.framing import Message
    from companion.vehicle.endpoints import Endpoint

SIMULATOR_PORT = 14580
"""The port at which the bundled simulator, like PX4 SITL, receives."""
LISTEN_S = 3.0
FREE_BYTES = 200_000_000
"""Free disk space for a run; an hour takes some 120 MB."""
_TAKEN = "choose another --instance or --connect; end that program only if it does not fly"
NOT_ASKED = "a vehicle was not asked for: --connect URL listens for one"


@dataclass(frozen=True)
class MachineFinding:
    """A line of the answer.

    Attributes:
        topic: what was checked, in a word.
        text: what was found.
        remedy: what to do; empty if all is in order.
    """

    topic: str
    text: str
    remedy: str = ""

    def __str__(self) -> str:
        mark = "no" if self.remedy else "ok"
        advice = f"\n{'':14}{self.remedy}" if self.remedy else ""
        return f"{mark:<3}{self.topic:<11}{self.text}{advice}"


def doctor(
    connect: Annotated[
        str | None,
        typer.Option(
            metavar="URL",
            help="Also listen here for a vehicle, as `companion run` does.",
            show_default="do not listen",
        ),
    ] = None,
    instance: Instance = 0,
    log_dir: LogDir = DEFAULT_LOG_DIR,
) -> None:
    """Checks whether this machine is ready for a flight, and says what to do. Changes nothing.

    The exit code is 1 if something is not in order.

    \b
    Examples:
      companion doctor
      companion doctor --connect serial:///dev/ttyACM0:57600
    """
    is_well = True
    for finding in _findings(connect, instance, log_dir.expanduser()):
        typer.echo(str(finding))
        is_well = is_well and not finding.remedy
    if not is_well:
        raise typer.Exit(1)


def _findings(connect: str | None, instance: int, log_dir: Path) -> Iterator[MachineFinding]:
    yield _program()
    yield _run_folders(log_dir)
    yield _missions()
    yield _simulator()
    yield _engines()
    yield _port(OFFBOARD_PORT + instance, "for `companion run`", _TAKEN)
    yield _port(SIMULATOR_PORT + instance, "for a simulator, PX4's or ours")
    yield _port(GROUND_STATION_PORT, "for a ground station such as QGroundControl")
    yield _port(DEFAULT_PAGE.port, "for the monitor page, else the next one")
    yield _browser()
    yield _vehicle(connect) if connect else MachineFinding("vehicle", NOT_ASKED)


def _program() -> MachineFinding:
    about = f"{DISTRIBUTION} {metadata.version(DISTRIBUTION)}, Python {platform.python_version()}"
    return MachineFinding(
        "program", f"{about}, {platform.system()} {platform.machine()}, {sys.prefix}"
    )


def _run_folders(log_dir: Path) -> MachineFinding:
    there = next(path for path in (log_dir, *log_dir.parents) if path.exists())
    if not os.access(there, os.W_OK | os.X_OK):
        return MachineFinding("runs", f"{log_dir} cannot be written", "choose another by --log-dir")
    free = shutil.disk_usage(there).free
    text = f"{log_dir}, {free / 1e9:.1f} GB free"
    short = free < FREE_BYTES
    return MachineFinding(
        "runs", text, "remove old runs: companion runs --prune 20" if short else ""
    )


def _missions() -> MachineFinding:
    lie_in = folder()
    if lie_in is None:
        return MachineFinding(
            "missions", "none is shipped with this installation; files work as usual"
        )
    pages = lie_in.parent / "docs"
    about = f"; the documentation in {pages}" if pages.is_dir() else ""
    return MachineFinding("missions", f"{len(names())} by name, in {lie_in}{about}")


def _simulator() -> MachineFinding:
    if find_spec("jsbsim") is not None:
        return MachineFinding(
            "simulator", f"JSBSim {metadata.version('jsbsim')}: companion sim flies"
        )
    if sys.platform == "linux" and platform.machine() != "x86_64":
        return MachineFinding(
            "simulator", "there is no JSBSim for this machine: companion sim does not fly"
        )
    return MachineFinding("simulator", "JSBSim is not installed", "pip install jsbsim")


def _engines() -> MachineFinding:
    engines = {"fast-downward": "up_fast_downward", "pyperplan": "up_pyperplan"}
    there = [name for name, module in engines.items() if find_spec(module) is not None]
    extra = f"pip install '{DISTRIBUTION}[planners]' brings fast-downward and pyperplan"
    return MachineFinding(
        "planners", ", ".join(["built-in", *there]) + ("" if there else f"; {extra}")
    )


def _port(port: int, use: str, remedy: str = "") -> MachineFinding:
    if holders := _holders(port):
        return MachineFinding(f"port {port}", f"{use}; taken by {', '.join(holders)}", remedy)
    return MachineFinding(f"port {port}", f"{use}; free")


def _holders(port: int) -> list[str]:
    """The programs that use a port, UDP or TCP, as far as the system shows them."""
    import psutil

    try:
        sockets = psutil.net_connections(kind="inet")
    except psutil.AccessDenied:
        return []
    found: dict[int | None, str] = {}
    for each in sockets:
        is_listening = each.laddr and each.laddr.port == port and not each.raddr
        if is_listening and each.pid not in found:
            found[each.pid] = _name(each.pid)
    return list(found.values())


def _name(pid: int | None) -> str:
    import psutil

    if pid is None:
        return "another user's program"
    try:
        return f"{' '.join(psutil.Process(pid).cmdline()[:4])} (process {pid})"
    except psutil.Error:
        return f"process {pid}"


def _browser() -> MachineFinding:
    import webbrowser

    try:
        return MachineFinding(
            "browser", f"{webbrowser.get().name} shows the monitor page with --open"
        )
    except webbrowser.Error:
        return MachineFinding(
            "browser", "none here; the monitor page can be opened from another machine"
        )


def _vehicle(url: str) -> MachineFinding:
    from companion.errors import LinkError
    from companion.vehicle.endpoints import SerialPort, parse_url

    try:
        endpoint = parse_url(url)
        if isinstance(endpoint, SerialPort) and (fault := _serial_fault(endpoint.device)):
            return fault
        heard, account = _listen(endpoint)
    except LinkError as error:
        what, *advice = str(error).splitlines()
        return MachineFinding(
            "vehicle", what, " ".join(" ".join(advice).split()) or "see the message"
        )
    if heard:
        return MachineFinding("vehicle", f"{url}: {heard}")
    remedy = "is it on, and does it send MAVLink to this address? docs/real-vehicle.md"
    return MachineFinding("vehicle", f"{url}: {account} in {LISTEN_S:g} s", remedy)


def _serial_fault(device: str) -> MachineFinding | None:
    """Why a serial port cannot be used; None if it can."""
    from serial.tools.list_ports import comports

    if not Path(device).exists():
        there = ", ".join(port.device for port in comports()) or "none"
        return MachineFinding("vehicle", f"there is no {device}", f"serial ports here: {there}")
    if not os.access(device, os.R_OK | os.W_OK):
        remedy = "sudo usermod -aG dialout $USER, then log in again"
        return MachineFinding("vehicle", f"{device} may not be opened by this user", remedy)
    return None


def _listen(endpoint: Endpoint) -> tuple[str, str]:
    """The autopilot's last heartbeat in words, empty if none; and what was received at all."""
    from contextlib import closing

    from companion.vehicle.link import Link
    from companion.vehicle.wire import Wire, is_autopilot

    heard, end_s, wire = "", time.monotonic() + LISTEN_S, Wire()
    wire.listen(frozenset(), frozenset())
    with closing(Link(endpoint)) as link:
        while (left_s := end_s - time.monotonic()) > 0:
            link.send([])
            link.wait(min(0.1, left_s))
            for message in wire.parse(link.receive()):
                heard = _in_words(message) if is_autopilot(message) else heard
        return heard, link.account()


def _in_words(heartbeat: Message) -> str:
    from companion.mavlink.framing import dialect, source
    from companion.mavlink.px4_modes import mode_name

    system = f"system {source(heartbeat)[0]}"
    if heartbeat.autopilot != dialect.MAV_AUTOPILOT_PX4:
        kind = dialect.enums["MAV_AUTOPILOT"][heartbeat.autopilot].name
        return f"{system}, an autopilot that is no PX4 ({kind}): its modes are not known here"
    is_armed = heartbeat.base_mode & dialect.MAV_MODE_FLAG_SAFETY_ARMED
    armed = "ARMED" if is_armed else "disarmed"
    return f"{system}, PX4, {mode_name(heartbeat.custom_mode) or 'in no known mode'}, {armed}"
