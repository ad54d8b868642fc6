"""Which run was cut off, so that `run --resume` goes on with it."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from companion.cli.arguments import load
from companion.errors import RequestError

if TYPE_CHECKING:
    from companion.acting.journal import JournalledFlight
    from companion.mission.model import Mission
    from companion.vehicle.link import Link

LATEST = "latest"
"""Among the run folders: a file with the name of the newest one of `companion run`. Names have the
time in them, but a companion computer without a clock of its own may be wrong about that."""

HEARD_S = 3.0
"""In which the autopilot of a run that was cut off tells what its clock shows."""


@dataclass(frozen=True)
class CutOffRun:
    """A run that was not ended by its own program."""

    folder: Path
    mission: Mission
    journalled: JournalledFlight


def mark_latest(folder: Path) -> None:
    """This run is the newest one, also if the power fails now."""
    new = folder.parent / f".{LATEST}.{os.getpid()}"
    with new.open("w", encoding="utf-8") as file:
        file.write(f"{folder.name}\n")
        file.flush()
        os.fsync(file.fileno())
    new.replace(folder.parent / LATEST)


def cut_off_run(log_dir: Path, asked: Mission | None) -> CutOffRun | None:
    """The newest run, if it was cut off after it was to arm; None if it was not.

    Args:
        log_dir: with the run folders.
        asked: the mission to go on with; None for that of the run.

    Raises:
        CompanionError: it was of another mission, or its journal is damaged.
    """
    from companion.mission.digest import digest
    from companion.record.events import JOURNAL_FILE
    from companion.record.journal_file import read_journal

    log_dir = log_dir.expanduser()
    latest = log_dir / LATEST
    if not latest.exists():
        return None
    folder = log_dir / latest.read_text(encoding="utf-8").strip()
    if not (folder / JOURNAL_FILE).exists():
        return None
    journalled = read_journal(folder, time.time())
    if journalled is None or journalled.is_over:
        return None
    begun = journalled.begun
    mission = asked or load(Path(begun.path))
    if digest(mission) != begun.digest:
        raise RequestError(
            f"{folder} was cut off while it flew {begun.mission}, which is not {mission.path}"
            " as it is now\n    give that mission to go on with it; or see to the vehicle, and"
            " start without --resume"
        )
    if mission.tree is not None:
        raise RequestError(
            f"{folder} was cut off, and a mission with a tree of its own is not gone on with\n"
            "    see to the vehicle, and start without --resume"
        )
    return CutOffRun(folder, mission, journalled)


def found_by_its_clock(cut_off: CutOffRun, link_of: Callable[[], Link]) -> CutOffRun:
    """The same run, with the time since then by the autopilot's clock, if that is heard.

    The wall clock of a companion computer without a battery for it is wrong after a loss of power.

    Args:
        cut_off: with the time by the wall clock.
        link_of: opens the link to the vehicle.
    """
    from companion.vehicle.boot_clock import told_boot_s
    from companion.vehicle.link import CALL_S

    if (seen := cut_off.journalled.seen) is None:
        return cut_off
    until_s = time.monotonic() + HEARD_S
    with closing(link_of()) as link:
        while (left_s := until_s - time.monotonic()) > 0.0:
            link.send([])  # an autopilot that is called speaks only then
            link.wait(min(left_s, CALL_S))
            if (boot_s := told_boot_s(link.receive(), seen.system)) is not None:
                return replace(cut_off, journalled=cut_off.journalled.found_at(boot_s))
    return cut_off
