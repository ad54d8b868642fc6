"""The command that flies a vehicle: run."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from companion.acting.arming_terms import ArmingTerms, UploadPolicy
from companion.cli.arguments import (
    DEFAULT_LOG_DIR,
    AutopilotFence,
    Events,
    Laps,
    LimitS,
    LinkUrl,
    LogDir,
    RallyPoints,
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
    EngineOption,
    EngineTimeout,
    engine_of,
)
from companion.cli.log_lines import Verbose
from companion.cli.monitoring import DEFAULT_ADDRESS, Monitor, monitored
from companion.cli.real_time import OFFBOARD_PORT, fly_over, raise_failure
from companion.cli.recording import close_run, flown_s, line, open_run, recorded
from companion.cli.resuming import CutOffRun, cut_off_run
from companion.cli.terminal import Terminal
from companion.planning.objective import Encoding

if TYPE_CHECKING:
    from companion.app import Companion
    from companion.flight_events.event import Stamped
    from companion.mission.model import Mission
    from companion.planning.engine_port import Engine
    from companion.record.run_folder import RunFolder

UPLOADS = "uploads"
"""Among the run folders: what ground stations have sent."""


def run(
    mission: Annotated[
        Path | None,
        typer.Argument(metavar="MISSION", help="The mission's YAML file; without: uploads."),
    ] = None,
    connect: LinkUrl = f"udpin://0.0.0.0:{OFFBOARD_PORT}",
    accept_weak_failsafes: WeakFailsafes = False,
    autopilot_fence: AutopilotFence = UploadPolicy.UPLOAD,
    rally_points: RallyPoints = UploadPolicy.UPLOAD,
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
    heard us: after a gap in the link, or, started again, after it was cut off in flight. A vehicle
    that has landed meanwhile is not armed again.
    """
    from companion.acting.flight_limit import FlightLimit
    from companion.app import Companion
    from companion.record.own_upload_file import own_uploads_in
    from companion.vehicle.endpoints import parse_url
    from companion.vehicle.link import Link

    loaded, endpoint = load(mission) if mission else None, parse_url(connect)
    address, planner = monitor or DEFAULT_ADDRESS, engine_of(engine, encoding, engine_timeout)
    cut_off = cut_off_run(log_dir, loaded) if resume else None
    companion_of = partial(
        Companion,
        terms=ArmingTerms(accept_weak_failsafes, autopilot_fence, rally_points),
        own_uploads=own_uploads_in(log_dir),
        limit=FlightLimit(laps, limit_s),
        resumes=resume,
        journalled=cut_off.journalled if cut_off else None,
    )
    with signing_of(signing_key, f"run-{endpoint.name}", unsigned_vehicle) as signing:
        fly = partial(fly_over, link_of=partial(Link, endpoint, signing), events=events)
        if loaded is None or wait:
            _host(companion_of, loaded, fly, log_dir, address, planner, cut_off)
        else:
            _fly_once(companion_of, loaded, fly, log_dir, address, planner, cut_off, timeout)


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
        raise_failure(companion.failure)


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
