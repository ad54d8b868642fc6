"""Flies missions over a link: on PX4, or on any simulator of it."""

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
"""The port to which PX4 sends its offboard link."""


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
    """Flies a mission on a vehicle, until it ends.

    Ctrl-C in the main thread makes the vehicle land and ends the flight. A second Ctrl-C leaves the
    vehicle to the autopilot's failsafe.

    >>> from companion import load_mission, run
    >>> run(load_mission("missions/field.yaml"), "udpin://127.0.0.1:14999", timeout_s=0.1)
    Traceback (most recent call last):
    ...
    companion.errors.LinkTimeout: no vehicle on udpin://127.0.0.1:14999 after 0 s: ...

    Args:
        mission: the mission to fly.
        connect: `udpin://HOST:PORT` to listen, `udpout://HOST:PORT` to send first,
            `tcpout://HOST:PORT`, or `serial://DEVICE:BAUD`.
        folder: where to write a run folder; None writes none.
        on_event: called with each event that is shown to people.
        accepts_weak_failsafes: fly although the autopilot's own failsafes are weak.
        autopilot_fence, rally_points: `upload`, `keep`, `replace` or `none`, as for `companion
            run`; what was uploaded is remembered beside `folder`, if there is one.
        laps, limit_s: laps, or seconds since arming was due, after which the vehicle goes home.
        timeout_s: seconds to wait for a vehicle.
        events: where other programs on board report events: `unix:PATH` or `udpin:HOST:PORT`.

    Returns:
        The result; its trajectory is the autopilot's estimate.

    Raises:
        LinkError: the link, or the port for events, cannot be opened; or no vehicle is heard.
        CompanionError: an argument has a wrong type or value; nothing was opened.
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
    """The result, once the flight has ended."""
    return FlightResult(
        mission=mission,
        events=tuple(recorder.events),
        trajectory=FlownTrajectory.of(recorder.positions),
        failure=failure,
        folder=Path(folder) if folder is not None else None,
    )


@contextmanager
def _stopped_by_interrupt(companion: Companion) -> Iterator[None]:
    """While this context lasts, Ctrl-C asks the companion once to end."""

    def stop(number: int, _: FrameType | None) -> None:
        signal.signal(number, before)
        companion.stop()

    try:
        before = signal.signal(signal.SIGINT, stop)
    except ValueError:  # this is not the main thread
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
