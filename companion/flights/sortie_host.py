"""The files and threads of a companion that flies several sorties."""

from __future__ import annotations

import threading
from concurrent.futures import Future
from pathlib import Path
from types import MappingProxyType

from companion.acting.preparation import PreparedMission, prepare
from companion.flight_events.event import Stamped
from companion.flights.cut_off_runs import CutOffRun
from companion.flights.monitor_page import Page
from companion.flights.run_folders import RunFolders
from companion.ground.operations import UploadService
from companion.mission.installed_calls import functions_of
from companion.mission.kept_domain import kept_domain
from companion.mission.loader import load_mission
from companion.mission.model import Mission
from companion.mission_run import Recorder
from companion.planning.engine_port import Engine
from companion.record.run_folder import RunFolder
from companion.skills.catalogue import Catalogue
from companion.skills.runner import FunctionRunner


class SortieHost:
    """A `run_sources.host.Host` with files: run folders and uploaded missions.

    Args:
        folders: opens and closes the run folders.
        page: shows the present run, or the last one.
        uploads: missions from outside; None if they are not accepted.
        functions: calls functions of installed packages; closed by its owner.
        engine: plans; None for the built-in search.
        installed: the functions installed at the program's start; a mission may call no others.
    """

    def __init__(
        self,
        folders: RunFolders,
        page: Page,
        uploads: UploadService | None,
        functions: FunctionRunner,
        engine: Engine | None = None,
        installed: Catalogue = MappingProxyType({}),
    ) -> None:
        self._engine = engine
        self._functions, self._installed = functions, installed
        self.uploads = uploads
        self._folders, self._page = folders, page
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

    def resume_run(self, cut_off: CutOffRun) -> Recorder:
        """Opens the folder of a run that was cut off, for the first run."""
        return self._begin(self._folders.open(cut_off.mission, cut_off))

    def begin_run(self, mission: Mission) -> Recorder:
        """Opens a run folder; notes that the active upload is started."""
        folder = self._begin(self._folders.open(mission))
        if self.uploads is not None:
            self.uploads.started()
        return folder

    def end_run(self, recorder: Recorder) -> None:
        """Closes the run folder in a thread: drawing takes a second, the heartbeat must go on."""
        folder, self._open = self._open, None
        assert folder is not None and recorder is folder
        self._closing.append(threading.Thread(target=self._folders.close, args=(folder,)))
        self._closing[-1].start()

    def tell(self, stamped: Stamped) -> None:
        """Shows news between two runs, without a time, which would seem to belong to a run."""
        self._folders.front_end.say(f"hosting    {stamped.event.text}")

    def close(self) -> None:
        """Closes what is still open, and waits for drawings."""
        if self._open is not None:
            self._folders.close(self._open)
        for thread in self._closing:
            thread.join()

    def _begin(self, folder: RunFolder) -> RunFolder:
        """Takes a folder for the run that begins."""
        self._open, self._functions.folder = folder, folder.folder
        self._page.show(folder.folder)
        return folder
