"""Flies missions over a link: on PX4, or on any simulator of it."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from companion.acting.sortie.flight_limit import FlightLimit
from companion.acting.sortie.preflight.arming_terms import ArmingTerms, UploadPolicy
from companion.acting.sortie.terms import SortieTerms
from companion.api.flight_arguments import check_flight_arguments
from companion.api.results import FlightResult, FlownTrajectory, OnEvent, recording
from companion.app import Companion
from companion.arguments import named
from companion.flight_events.event import Stamped
from companion.flights.only_flight import only_flight
from companion.flights.options import FlightOptions, LinkOptions
from companion.flights.over_link import fly_over_link
from companion.flights.stopping import stopped_by
from companion.mission.model import Mission
from companion.record.flight_memory_files import flight_memory_in
from companion.vehicle.endpoints import OFFBOARD_URL, parse_url


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
    options = FlightOptions(SortieTerms(arming, FlightLimit(laps, limit_s)))
    link = LinkOptions(parse_url(connect), events=events, timeout_s=timeout_s)
    run_folder = Path(folder) if folder is not None else None
    memory = flight_memory_in(run_folder.parent) if run_folder is not None else None
    with (
        recording(mission, run_folder, on_event) as recorder,
        only_flight(mission, recorder, options, folder=run_folder, memory=memory) as companion,
    ):
        fly_over_link(companion, link, PythonProgram())
    trajectory = FlownTrajectory.of(recorder.positions)
    return FlightResult(mission, tuple(recorder.events), trajectory, companion.failure, run_folder)


def _arming(accepts_weak_failsafes: bool, autopilot_fence: str, rally_points: str) -> ArmingTerms:
    return ArmingTerms(
        accepts_weak_failsafes,
        fence=named(UploadPolicy, autopilot_fence, "autopilot_fence"),
        rally_points=named(UploadPolicy, rally_points, "rally_points"),
    )


class PythonProgram:
    """The `FrontEnd` of somebody's own program: it shows nothing, and Ctrl-C ends the flight."""

    def say(self, line: str, is_error: bool = False) -> None:
        """Shows nothing."""

    def tell(self, stamped: Stamped) -> None:
        """Shows nothing; the program gets its events by `on_event`."""

    @contextmanager
    def attending(self, companion: Companion) -> Iterator[Callable[[], None]]:
        """While the context lasts, Ctrl-C ends the flight."""
        with stopped_by([signal.SIGINT], companion, on_stop=lambda: None):
            yield lambda: None
