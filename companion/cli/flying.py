"""The command that flies a vehicle: run."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from companion.acting.preflight.arming_terms import ArmingTerms, UploadPolicy
from companion.cli.arguments import (
    DEFAULT_LOG_DIR,
    AutopilotFence,
    Contingencies,
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
from companion.cli.monitoring import DEFAULT_ADDRESS, Monitor
from companion.cli.real_time import OFFBOARD_PORT
from companion.cli.shipped import completions, mission_file
from companion.cli.vehicle_flights import VehicleFlights
from companion.planning.objective import Encoding

if TYPE_CHECKING:
    from companion.mission.model import Mission

OptionalMission = Annotated[
    Path | None,
    typer.Argument(
        metavar="MISSION",
        parser=mission_file,
        autocompletion=completions,
        help="The YAML file of a mission, or the name of an example mission. Without it, the "
        "companion waits for an upload.",
    ),
]

Wait = Annotated[
    bool,
    typer.Option(
        "--wait", help="Wait for the start command of a ground station, before each flight."
    ),
]


def run(
    mission: OptionalMission = None,
    connect: LinkUrl = f"udpin://0.0.0.0:{OFFBOARD_PORT}",
    accept_weak_failsafes: WeakFailsafes = False,
    autopilot_fence: AutopilotFence = UploadPolicy.UPLOAD,
    rally_points: RallyPoints = UploadPolicy.UPLOAD,
    wait: Wait = False,
    resume: Resume = False,
    events: Events = None,
    laps: Laps = None,
    limit_s: LimitS = None,
    contingencies: Contingencies = False,
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

    With --wait, or without MISSION, the companion waits on the ground until a
    ground station sends MAV_CMD_MISSION_START. It flies, lands, and waits again,
    until you stop it.

    With --resume, the companion takes control back by itself if the autopilot
    holds because it no longer heard the companion. That happens after a gap in
    the link, or when the companion was killed in flight and is started again. A
    vehicle that has landed meanwhile is not armed again.
    """
    from companion.acting.flight_limit import FlightLimit
    from companion.acting.sortie_terms import SortieTerms
    from companion.vehicle.endpoints import parse_url
    from companion.vehicle.link import Link

    if contingencies and (mission is None or resume):
        reason = "needs MISSION, and no --resume: a vehicle in the air would wait for the table"
        raise typer.BadParameter(reason, param_hint="--contingencies")
    loaded = load(mission, contingencies) if mission else None
    _notice_unheard(loaded, events)
    endpoint = parse_url(connect)
    arming = ArmingTerms(accept_weak_failsafes, autopilot_fence, rally_points)
    with signing_of(signing_key, f"run-{endpoint.name}", unsigned_vehicle) as signing:
        flights = VehicleFlights(
            partial(Link, endpoint, signing),
            events=events,
            log_dir=log_dir,
            address=monitor or DEFAULT_ADDRESS,
            engine=engine_of(engine, encoding, engine_timeout, None, loaded),
            terms=SortieTerms(arming, limit=FlightLimit(laps, limit_s), resumes=resume),
        )
        if loaded is None or wait:
            flights.host(loaded)
        else:
            flights.fly_once(loaded, timeout)


def _notice_unheard(mission: Mission | None, events: str | None) -> None:
    """Prints which reports, `EVENT[name]`, a mission needs if none can be received."""
    from companion.planning.notices import not_heard

    if mission is not None and events is None:
        for notice in not_heard(mission):
            typer.echo(f"notice     {notice}")
