"""The run folder of a command that flies, announced at the start and at the end."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from companion.cli.resuming import CutOffRun, mark_latest
from companion.cli.terminal import Terminal
from companion.cli.times import minutes
from companion.errors import CompanionError, LinkError

if TYPE_CHECKING:
    from companion.flight_events.event import Stamped
    from companion.mission.model import Mission
    from companion.record.run_folder import RunFolder


@contextmanager
def recorded(
    mission: Mission,
    log_dir: Path,
    terminal: Terminal,
    keeps_journal: bool = False,
    cut_off: CutOffRun | None = None,
) -> Iterator[RunFolder]:
    """A run folder, announced at the start and at the end.

    A flight that found no vehicle has an end, too.
    """

    from companion.flight_events.event import Stamped
    from companion.flight_events.sortie import RunFailed

    def tell(stamped: Stamped) -> None:
        if not isinstance(stamped.event, RunFailed):  # `main` prints a failure, once
            terminal.say(line(stamped))

    folder = open_run(mission, log_dir, tell, terminal, keeps_journal, cut_off)
    begun_s = time.monotonic()
    try:
        yield folder
    except LinkError as error:
        if cut_off is None and not folder.has_ended:
            ending = RunFailed(str(error), error.exit_code)
            folder.report(Stamped(time.monotonic() - begun_s, ending))
        raise
    finally:
        close_run(folder, terminal)


def open_run(
    mission: Mission,
    log_dir: Path,
    tell: Callable[[Stamped], None],
    terminal: Terminal,
    keeps_journal: bool,
    cut_off: CutOffRun | None,
) -> RunFolder:
    """The folder of a new run, or of one that was cut off.

    Raises:
        CompanionError: nothing can be written there.
    """
    from companion.record.drawing import draw_here, draw_in_child, draw_record_in_child
    from companion.record.run_folder import RunFolder

    now_s = time.time()
    terminal.say(f"mission    {mission.name}")
    if cut_off is not None:
        run_s = flown_s(cut_off) - cut_off.journalled.begun.start_s
        path, start_s = cut_off.folder, now_s - run_s
    else:
        path, start_s = _new_path(mission.name, log_dir, now_s), now_s
    cut_off_at = cut_off.journalled.positions if cut_off is not None else None
    draw = draw_in_child if keeps_journal else draw_here
    if cut_off is not None:
        draw = draw_record_in_child
    try:
        folder = RunFolder(path, mission, start_s, tell, keeps_journal, cut_off_at, draw)
    except OSError as error:
        raise CompanionError(
            f"the run folder {path} cannot be written: {error.strerror}\n"
            "    --log-dir DIR makes run folders in another place"
        ) from error
    if keeps_journal:
        mark_latest(path)
    terminal.say(f"run        {path}")
    return folder


def _new_path(name: str, log_dir: Path, now_s: float) -> Path:
    """The path of a new folder, named by the time and the mission."""
    stamp = time.strftime("%Y-%m-%dT%H%M%S", time.localtime(now_s))
    path = log_dir.expanduser() / f"{stamp}-{name}"
    number = 1
    while path.exists():
        number += 1
        path = path.with_name(f"{stamp}-{name}-{number}")
    return path


def flown_s(cut_off: CutOffRun | None) -> float:
    """The present time of the flight's clock."""
    return cut_off.journalled.goes_on_s if cut_off else 0.0


def close_run(folder: RunFolder, terminal: Terminal) -> None:
    """Closes a run folder and announces it."""
    folder.close()
    terminal.say(f"results    {folder.folder}")


def line(stamped: Stamped) -> str:
    """An event as a line for the terminal."""
    return f" {minutes(stamped.time_s)}  {stamped.event.text}"
