"""What `simulate` and `run` take alike, held against what it may be before anything begins."""

from __future__ import annotations

from pathlib import Path
from types import NoneType

from companion.errors import CompanionError, check_kind
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
    """Refuses what no flight takes.

    Raises:
        CompanionError: something is of another kind.
    """
    check_kind(mission, Mission, "a mission, as of load_mission")
    check_kind(folder, (Path, str, NoneType), "the path of a folder")
    check_kind(laps, (int, NoneType), "a number of laps")
    check_kind(limit_s, (int, float, NoneType), "a limit_s in seconds")
    check_kind(timeout_s, (int, float), "a timeout_s in seconds")
    check_kind(connect, str, "the URL of a link")
    check_kind(events, (str, NoneType), "where events are reported, as a text")
    if on_event is not None and not callable(on_event):
        kind = type(on_event).__name__
        raise CompanionError(f"expected a function as on_event, and this is a {kind}")
