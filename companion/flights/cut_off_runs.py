"""Finds the run that was cut off, to be resumed."""

from __future__ import annotations

import os
import time
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

from companion.acting.journal import JournalledFlight
from companion.errors import RequestError
from companion.flights.options import LinkOptions
from companion.mission.digest import digest
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.record.events import JOURNAL_FILE
from companion.record.journal_file import read_journal
from companion.vehicle.boot_clock import told_boot_s
from companion.vehicle.link import CALL_S

LATEST = "latest"
"""A file beside the run folders with the name of the newest one of `companion run`. Names contain
the time, but a companion computer without a clock of its own may have a wrong one."""

HEARD_S = 3.0
"""Time within which the autopilot of a cut-off run reports its clock."""


@dataclass(frozen=True)
class CutOffRun:
    """A run that its own program has not ended."""

    folder: Path
    mission: Mission
    journalled: JournalledFlight


def mark_latest(folder: Path) -> None:
    """Notes that this run is the newest one, safely even if the power fails now."""
    new = folder.parent / f".{LATEST}.{os.getpid()}"
    with new.open("w", encoding="utf-8") as file:
        file.write(f"{folder.name}\n")
        file.flush()
        os.fsync(file.fileno())
    new.replace(folder.parent / LATEST)


def cut_off_run(log_dir: Path, asked: Mission | None) -> CutOffRun | None:
    """The newest run, if it was cut off after arming was due; None otherwise.

    Args:
        log_dir: contains the run folders.
        asked: the mission to continue with; None means that of the run.

    Raises:
        CompanionError: it was a run of another mission, or its journal is damaged.
    """
    latest = log_dir / LATEST
    if not latest.exists():
        return None
    folder = log_dir / latest.read_text(encoding="utf-8").strip()
    if not (folder / JOURNAL_FILE).exists():
        return None
    journalled = read_journal(folder, time.time())
    if journalled is None:
        return None
    begun = journalled.begun
    mission = asked or load_mission(Path(begun.path))
    if digest(mission) != begun.digest:
        raise RequestError(
            f"{folder} was cut off while it flew {begun.mission}, which is not {mission.path}"
            " as it is now\n    give that mission to resume it; or check the vehicle, and"
            " start without --resume"
        )
    if mission.tree is not None:
        raise RequestError(
            f"{folder} was cut off, and a mission with a tree of its own cannot be resumed\n"
            "    check the vehicle, and start without --resume"
        )
    return CutOffRun(folder, mission, journalled)


def found_by_its_clock(cut_off: CutOffRun, options: LinkOptions) -> CutOffRun:
    """The same run, with the time since the cut by the autopilot's clock, if that is heard.

    After a loss of power, the wall clock of a companion computer without a clock battery is wrong.

    Args:
        cut_off: with the time by the wall clock.
        options: the link to the vehicle.
    """
    if (seen := cut_off.journalled.seen) is None:
        return cut_off
    until_s = time.monotonic() + HEARD_S
    with closing(options.open()) as link:
        while (left_s := until_s - time.monotonic()) > 0.0:
            link.send([])  # some autopilots send nothing until they receive something
            link.wait(min(left_s, CALL_S))
            if (boot_s := told_boot_s(link.receive(), seen.system)) is not None:
                return replace(cut_off, journalled=cut_off.journalled.found_at(boot_s))
    return cut_off
