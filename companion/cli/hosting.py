"""Runs of a companion that flies several sorties: run folders, and missions from outside."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from companion.acting.preparation import PreparedMission, prepare
from companion.mission.installed_calls import functions_of
from companion.mission.kept_domain import kept_domain
from companion.mission.loader import load_mission
from companion.skills.catalogue import Catalogue
from companion.skills.runner import FunctionRunner

if TYPE_CHECKING:
    from companion.flight_events.event import Stamped
    from companion.ground.operations import UploadService
    from companion.mission.model import Mission
    from companion.mission_run import Recorder
    from companion.planning.engine_port import Engine
    from companion.record.run_folder import RunFolder


class SortieHost:
    """A `run_sources.host.Host` with files: run folders and uploaded missions.

    Args:
        open_folder: creates and announces a run folder.
        close_folder: closes a run folder and announces that.
        tell: prints news between two runs.
        uploads: missions from outside; None if they are not accepted.
        functions: calls functions of installed packages; closed by its owner.
        engine: plans; None for the built-in search.
        installed: the functions installed at the program's start; a mission may call no others.
    """

    def __init__(
        self,
        open_folder: Callable[[Mission], RunFolder],
        close_folder: Callable[[RunFolder], None],
        tell: Callable[[Stamped], None],
        uploads: UploadService | None,
        functions: FunctionRunner,
        engine: Engine | None = None,
        installed: Catalogue = MappingProxyType({}),
    ) -> None:
        self._engine = engine
        self._functions, self._installed = functions, installed
        self.uploads = uploads
        self._open_folder = open_folder
        self._close_folder = close_folder
        self._tell = tell
        self._open: RunFolder | None = None
        self._closing: list[threading.Thread] = []

    def load(self, path: Path) -> Mission:
        """Reads an accepted mission; its PDDL files were read when it was checked.

        The functions that it calls start to load.
        """
        mission = load_mission(path, None, kept_domain, lambda _: self._installed)
        self._functions.prepare(functions_of(mission))
        return mission

    def prepare(
        self, mission: Mission, speed_max_mps: float, ground_amsl_m: float | None
    ) -> Future[PreparedMission]:
        """Prepares a mission in a thread: this takes seconds, and the heartbeat must continue.

        At its end, the program does not wait for it.
        """
        prepared: Future[PreparedMission] = Future()

        def work() -> None:
            try:
                made = prepare(
                    mission,
                    speed_max_mps,
                    engine=self._engine,
                    ground_amsl_m=ground_amsl_m,
                    functions=self._functions,
                )
                prepared.set_result(made)
            except BaseException as error:  # raised again in the loop, when the result is used
                prepared.set_exception(error)

        threading.Thread(target=work, daemon=True).start()
        return prepared

    def resume_run(self, folder: RunFolder) -> Recorder:
        """Takes the folder of a run that was cut off as that of the first run."""
        self._open, self._functions.folder = folder, folder.folder
        return folder

    def begin_run(self, mission: Mission) -> Recorder:
        """Opens a run folder; notes that the active upload is started."""
        self._open = self._open_folder(mission)
        self._functions.folder = self._open.folder
        if self.uploads is not None:
            self.uploads.started()
        return self._open

    def end_run(self, recorder: Recorder) -> None:
        """Closes the run folder in a thread: drawing takes a second, the heartbeat must go on."""
        folder, self._open = self._open, None
        assert folder is not None and recorder is folder
        self._closing.append(threading.Thread(target=self._close_folder, args=(folder,)))
        self._closing[-1].start()

    def tell(self, stamped: Stamped) -> None:
        """Prints news between two runs."""
        self._tell(stamped)

    def close(self) -> None:
        """Closes what is still open, and waits for drawings."""
        if self._open is not None:
            self._close_folder(self._open)
        for thread in self._closing:
            thread.join()
