"""The command that flies a vehicle: run."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from companion.acting.sortie.preflight.arming_terms import ArmingTerms, UploadPolicy
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
from companion.cli.monitoring import DEFAULT_PAGE, Monitor
from companion.cli.shipped import completions, mission_file
from companion.cli.terminal import Terminal
from companion.planning.objective import Encoding
from companion.vehicle.endpoints import OFFBOARD_URL, parse_url

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
    connect: LinkUrl = OFFBOARD_URL,
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
    from companion.acting.sortie.flight_limit import FlightLimit
    from companion.acting.sortie.terms import SortieTerms
    from companion.flights.options import FlightOptions, LinkOptions
    from companion.flights.vehicle_flights import VehicleFlights

    loaded = _loaded(mission, contingencies, resume, events)
    endpoint = parse_url(connect)
    arming = ArmingTerms(accept_weak_failsafes, autopilot_fence, rally_points)
    terms = SortieTerms(arming, FlightLimit(laps, limit_s), resumes=resume)
    planner = engine_of(engine, encoding, engine_timeout, None, loaded)
    with (
        closing(Terminal()) as terminal,
        signing_of(signing_key, f"run-{endpoint.name}", unsigned_vehicle) as signing,
    ):
        flights = VehicleFlights(
            FlightOptions(terms, planner),
            LinkOptions(endpoint, signing, events, timeout),
            log_dir=log_dir.expanduser(),
            page=monitor or DEFAULT_PAGE,
            front_end=terminal,
        )
        if loaded is None or wait:
            flights.host(loaded)
        elif (failure := flights.fly_once(loaded)) is not None:
            raise failure


def _loaded(
    file: Path | None, contingencies: bool, resume: bool, events: str | None
) -> Mission | None:
    """The mission; prints which reports, `EVENT[name]`, it needs if none can be received."""
    from companion.planning.notices import not_heard

    if contingencies and (file is None or resume):
        reason = "needs MISSION, and no --resume: a vehicle in the air would wait for the table"
        raise typer.BadParameter(reason, param_hint="--contingencies")
    if file is None:
        return None
    mission = load(file, contingencies)
    for notice in not_heard(mission) if events is None else ():
        typer.echo(f"notice     {notice}")
    return mission
