"""The run folders of a program, announced when they are opened and closed."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from companion.errors import CompanionError
from companion.flight_events.event import Stamped
from companion.flight_events.sortie import RunFailed
from companion.flights.cut_off_runs import CutOffRun, mark_latest
from companion.flights.front_end import FrontEnd
from companion.mission.model import Mission
from companion.record.drawing import draw_here, draw_in_child, draw_record_in_child
from companion.record.run_folder import RunFolder


@dataclass(frozen=True)
class RunFolders:
    """Opens and closes run folders in one directory.

    Attributes:
        log_dir: contains the run folders.
        front_end: shows where they are, and the events of their runs.
        keeps_journal: whether a run that is cut off can be resumed.
    """

    log_dir: Path
    front_end: FrontEnd
    keeps_journal: bool = False

    @contextmanager
    def recorded(self, mission: Mission, cut_off: CutOffRun | None = None) -> Iterator[RunFolder]:
        """The folder of a program's only run; the program shows its failure, at its end.

        Args:
            mission: the mission to fly.
            cut_off: the run to resume, if there is one.
        """

        def tell(stamped: Stamped) -> None:
            if not isinstance(stamped.event, RunFailed):
                self.front_end.tell(stamped)

        folder = self._open(mission, cut_off, tell)
        try:
            yield folder
        finally:
            self.close(folder)

    def open(self, mission: Mission, cut_off: CutOffRun | None = None) -> RunFolder:
        """Opens the folder of one of several runs.

        Args:
            mission: the mission to fly.
            cut_off: the run to resume, if there is one.

        Raises:
            CompanionError: nothing can be written there.
        """
        return self._open(mission, cut_off, self.front_end.tell)

    def close(self, folder: RunFolder) -> None:
        """Closes a folder."""
        folder.close()
        self.front_end.say(f"results    {folder.folder}")

    def _open(
        self, mission: Mission, cut_off: CutOffRun | None, tell: Callable[[Stamped], None]
    ) -> RunFolder:
        now_s = time.time()
        self.front_end.say(f"mission    {mission.name}")
        draw = draw_in_child if self.keeps_journal else draw_here
        path, start_s, cut_off_at = self._new_path(mission.name, now_s), now_s, None
        if cut_off is not None:
            flown = cut_off.journalled
            path, start_s = cut_off.folder, now_s - (flown.goes_on_s - flown.begun.start_s)
            cut_off_at, draw = flown.positions, draw_record_in_child
        try:
            folder = RunFolder(path, mission, start_s, tell, self.keeps_journal, cut_off_at, draw)
        except OSError as error:
            raise CompanionError(
                f"the run folder {path} cannot be written: {error.strerror}\n"
                "    --log-dir DIR makes run folders in another place"
            ) from error
        if self.keeps_journal:
            mark_latest(path)
        self.front_end.say(f"run        {path}")
        return folder

    def _new_path(self, name: str, now_s: float) -> Path:
        """The path of a new folder, named by the time and the mission."""
        stamp = time.strftime("%Y-%m-%dT%H%M%S", time.localtime(now_s))
        path = self.log_dir / f"{stamp}-{name}"
        number = 1
        while path.exists():
            number += 1
            path = path.with_name(f"{stamp}-{name}-{number}")
        return path
