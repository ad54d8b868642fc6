"""Checks the arguments that `simulate` and `run` share, before anything begins."""

from __future__ import annotations

from types import NoneType

from companion.arguments import check_function, check_kind, check_wait, path_of
from companion.mission.model import Mission


def check_flight_arguments(
    mission: object,
    folder: object,
    on_event: object,
    laps: object,
    limit_s: object,
    timeout_s: object,
    connect: object = "",
    events: object = None,
) -> None:
    """Refuses arguments that no flight accepts.

    Raises:
        CompanionError: an argument has a wrong type or value.
    """
    check_kind(mission, Mission, "a mission, as of load_mission")
    if folder is not None:
        path_of(folder, "the path of a folder")
    check_kind(laps, (int, NoneType), "a number of laps")
    check_kind(limit_s, (int, float, NoneType), "a limit_s in seconds")
    check_wait(timeout_s)
    check_kind(connect, str, "the URL of a link")
    check_kind(events, (str, NoneType), "where events are reported, as a text")
    if on_event is not None:
        check_function(on_event, "on_event")
