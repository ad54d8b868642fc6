"""A companion on a link: PX4, or any simulator of one."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from types import FrameType

from companion.acting.flight_limit import FlightLimit
from companion.acting.preflight.arming_terms import ArmingTerms, UploadPolicy
from companion.acting.sortie_terms import SortieTerms
from companion.api.flight_arguments import check_flight_arguments
from companion.api.results import FlightResult, FlownTrajectory, OnEvent, Recording, recording
from companion.app import Companion
from companion.arguments import named
from companion.clock import ScaledClock
from companion.driving import fly
from companion.errors import CompanionError
from companion.mission.model import Mission
from companion.record.flight_memory_files import flight_memory_in
from companion.run_sources.only_run import OnlyRun
from companion.skills.runner import FunctionRunner
from companion.vehicle.endpoints import parse_url
from companion.vehicle.flight_memory import FlightMemory
from companion.vehicle.link import Link
from companion.vehicle.report_port import reports_at

OFFBOARD_URL = "udpin://0.0.0.0:14540"
"""Where PX4 sends its offboard stream."""


def run(
    mission: Mission,
    connect: str = OFFBOARD_URL,
    *,
    folder: Path | str | None = None,
    on_event: OnEvent | None = None,
    accepts_weak_failsafes: bool = False,
    autopilot_fence: str = "upload",
    rally_points: str = "upload",
    laps: int | None = None,
    limit_s: float | None = None,
    timeout_s: float = 30.0,
    events: str | None = None,
) -> FlightResult:
    """Flies a mission on a vehicle, to its end.

    Ctrl-C, in the main thread, lands and ends the flight; a second one leaves the vehicle to its
    own failsafe.

    >>> from companion import load_mission, run
    >>> run(load_mission("missions/field.yaml"), "udpin://127.0.0.1:14999", timeout_s=0.1)
    Traceback (most recent call last):
    ...
    companion.errors.LinkTimeout: no vehicle on udpin://127.0.0.1:14999 after 0 s: ...

    Args:
        mission: what to do.
        connect: `udpin://HOST:PORT` to listen, `udpout://HOST:PORT` to send first,
            `tcpout://HOST:PORT`, or `serial://DEVICE:BAUD`.
        folder: where to write a run folder; none by default.
        on_event: told of each event that is news for people.
        accepts_weak_failsafes: fly although the autopilot's own failsafes are weak.
        autopilot_fence, rally_points: `upload`, `keep`, `replace` or `none`, as `companion run` has
            them; what was uploaded is remembered beside `folder`, if there is one.
        laps, limit_s: after so many laps, or seconds since it was to arm, it is called home.
        timeout_s: seconds to wait for a vehicle.
        events: where other programs on board report events: `unix:PATH` or `udpin:HOST:PORT`.

    Returns:
        What happened; its trajectory is where the autopilot believed to be.

    Raises:
        LinkError: the link, or the port for events, cannot be opened; or no vehicle is heard.
        CompanionError: an argument is not what it may be; nothing has been opened then.
    """
    check_flight_arguments(mission, folder, on_event, laps, limit_s, timeout_s, connect, events)
    arming = _arming(accepts_weak_failsafes, autopilot_fence, rally_points)
    terms, memory = SortieTerms(arming, FlightLimit(laps, limit_s)), _remembered_beside(folder)
    with (
        closing(Link(parse_url(connect))) as link,
        reports_at(events) as reports,
        recording(mission, folder, on_event) as recorder,
        closing(FunctionRunner(Path(folder) if folder is not None else None)) as functions,
    ):
        only = OnlyRun(mission, recorder, functions=functions)
        companion = Companion(only, terms, memory=memory)
        with _stopped_by_interrupt(companion):
            fly(companion, link, ScaledClock(1.0), timeout_s, reports=reports)
    return _result(mission, recorder, companion.failure, folder)


def _remembered_beside(folder: Path | str | None) -> FlightMemory | None:
    return flight_memory_in(Path(folder).parent) if folder is not None else None


def _arming(accepts_weak_failsafes: bool, autopilot_fence: str, rally_points: str) -> ArmingTerms:
    return ArmingTerms(
        accepts_weak_failsafes,
        fence=named(UploadPolicy, autopilot_fence, "autopilot_fence"),
        rally_points=named(UploadPolicy, rally_points, "rally_points"),
    )


def _result(
    mission: Mission, recorder: Recording, failure: CompanionError | None, folder: Path | str | None
) -> FlightResult:
    """What happened, once the flight has ended."""
    return FlightResult(
        mission=mission,
        events=tuple(recorder.events),
        trajectory=FlownTrajectory.of(recorder.positions),
        failure=failure,
        folder=Path(folder) if folder is not None else None,
    )


@contextmanager
def _stopped_by_interrupt(companion: Companion) -> Iterator[None]:
    """Ctrl-C asks the companion to end, once."""

    def stop(number: int, _: FrameType | None) -> None:
        signal.signal(number, before)
        companion.stop()

    try:
        before = signal.signal(signal.SIGINT, stop)
    except ValueError:  # not the main thread
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
