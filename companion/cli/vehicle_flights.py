"""Flights of a vehicle from the command line: one mission once, or those of ground stations.

`VehicleFlights` has what both share: the link, the run folders, the page, the planner, the terms of
arming, and the run that was cut off, if it is to be continued.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from companion.cli.monitoring import Page, monitored
from companion.cli.real_time import fly_over, raise_failure
from companion.cli.recording import close_run, flown_s, line, open_run, recorded
from companion.cli.resuming import CutOffRun, cut_off_run, found_by_its_clock
from companion.cli.terminal import Terminal

if TYPE_CHECKING:
    from companion.acting.function_port import FunctionPort
    from companion.acting.sortie_terms import SortieTerms
    from companion.app import Companion
    from companion.flight_events.event import Stamped
    from companion.mission.model import Mission
    from companion.mission_run import Recorder
    from companion.planning.engine_port import Engine
    from companion.record.run_folder import RunFolder
    from companion.run_sources.only_run import OnlyRun
    from companion.run_sources.run_source import RunSource
    from companion.vehicle.link import Link

UPLOADS = "uploads"
"""A folder beside the run folders, for uploads of ground stations."""


@dataclass(frozen=True)
class VehicleFlights:
    """What flights of one vehicle need.

    Attributes:
        link_of: opens the link to the vehicle.
        events: where other programs on board report events; None if nowhere.
        log_dir: contains the run folders.
        address: the address of the monitor page.
        engine: plans; None for the built-in search.
        terms: the operator's choices for all flights; with `resumes`, a cut-off run is continued.
    """

    link_of: Callable[[], Link]
    events: str | None
    log_dir: Path
    address: str
    engine: Engine | None
    terms: SortieTerms

    def fly_once(self, mission: Mission, timeout_s: float) -> None:
        """Flies one mission, or continues a cut-off run; raises its failure."""
        from companion.skills.runner import FunctionRunner

        cut_off = self._cut_off(mission)
        terminal = Terminal()
        with (
            closing(terminal),
            recorded(mission, self.log_dir, terminal, True, cut_off) as folder,
            monitored(self.address, terminal.say) as page,
            closing(FunctionRunner(folder.folder)) as functions,
        ):
            page.show(folder.folder)
            companion = self._companion(self._run(mission, folder, functions, cut_off), page)
            self._fly(companion, terminal, timeout_s, cut_off)
            raise_failure(companion.failure)

    def host(self, mission: Mission | None) -> None:
        """Waits for sorties of ground stations until stopped; first continues a cut-off run.

        Args:
            mission: the mission that they may start before they have sent another one.
        """
        from companion.cli.hosting import SortieHost
        from companion.ground.checking import CheckChildren
        from companion.ground.uploads import Uploads
        from companion.mission.installed_calls import functions_of
        from companion.run_sources.hosted_runs import HostedRuns
        from companion.skills.installed import read_all
        from companion.skills.runner import FunctionRunner

        cut_off = self._cut_off(mission)
        terminal = Terminal()

        def tell(stamped: Stamped) -> None:
            terminal.say(line(stamped))

        def tell_between(stamped: Stamped) -> None:
            """Prints an event without its time, which would seem to belong to a run."""
            terminal.say(f"hosting    {stamped.event.text}")

        with (
            closing(terminal),
            closing(FunctionRunner()) as functions,
            monitored(self.address, terminal.say) as page,
        ):

            def open_folder(mission: Mission, cut_off: CutOffRun | None = None) -> RunFolder:
                folder = open_run(mission, self.log_dir, tell, terminal, True, cut_off)
                page.show(folder.folder)
                return folder

            installed = read_all()
            children = CheckChildren(installed, self.events is not None)
            uploads = Uploads(self.log_dir.expanduser() / UPLOADS, children.begin)
            host = SortieHost(
                open_folder,
                close_folder=partial(close_run, terminal=terminal),
                tell=tell_between,
                uploads=uploads,
                engine=self.engine,
                functions=functions,
                installed=installed,
            )
            first = None
            if cut_off is not None:
                mission = cut_off.mission
                recorder = host.resume_run(open_folder(mission, cut_off))
                first = self._run(mission, recorder, functions, cut_off)
            functions.prepare(functions_of(mission) if mission else ())
            companion = self._companion(HostedRuns(host, mission, first), page)
            with closing(children), closing(uploads), closing(host):
                what = f"to fly {mission.name}" if mission else "and a mission"
                terminal.say(f"hosting    waits for MAV_CMD_MISSION_START {what}; Ctrl-C ends it")
                self._fly(companion, terminal, 0.0, cut_off)

    def _cut_off(self, mission: Mission | None) -> CutOffRun | None:
        """The run to continue, if there is one and it is asked for."""
        cut_off = cut_off_run(self.log_dir, mission) if self.terms.resumes else None
        return found_by_its_clock(cut_off, self.link_of) if cut_off else None

    def _fly(
        self, companion: Companion, terminal: Terminal, timeout_s: float, cut_off: CutOffRun | None
    ) -> None:
        begin_s = flown_s(cut_off)
        fly_over(
            companion, terminal, 1.0, timeout_s, begin_s, link_of=self.link_of, events=self.events
        )

    def _run(
        self,
        mission: Mission,
        recorder: Recorder,
        functions: FunctionPort,
        cut_off: CutOffRun | None,
    ) -> OnlyRun:
        """One run, from its beginning or from where it was cut off."""
        from companion.run_sources.only_run import OnlyRun

        journalled = cut_off.journalled if cut_off else None
        return OnlyRun(
            mission, recorder, engine=self.engine, functions=functions, journalled=journalled
        )

    def _companion(self, runs: RunSource, page: Page) -> Companion:
        from companion.app import Companion
        from companion.record.flight_memory_files import flight_memory_in

        return Companion(runs, self.terms, page=page, memory=flight_memory_in(self.log_dir))
