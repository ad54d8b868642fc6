"""Missions that ground stations start, one after the other, until the program ends."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager

from companion.app import Companion
from companion.flights.cut_off_runs import CutOffRun
from companion.flights.monitor_page import Page
from companion.flights.options import FlightOptions
from companion.flights.run_folders import RunFolders
from companion.flights.sortie_host import SortieHost
from companion.ground.checking import CheckChildren
from companion.ground.uploads import Uploads
from companion.mission.installed_calls import functions_of
from companion.mission.model import Mission
from companion.run_sources.hosted_runs import HostedRuns
from companion.run_sources.only_run import OnlyRun
from companion.skills.installed import read_all
from companion.skills.runner import FunctionRunner
from companion.vehicle.flight_memory import FlightMemory

UPLOADS = "uploads"
"""A folder beside the run folders, for uploads of ground stations."""


@contextmanager
def hosted_flights(
    mission: Mission | None,
    folders: RunFolders,
    options: FlightOptions,
    *,
    page: Page,
    memory: FlightMemory,
    cut_off: CutOffRun | None,
    has_reports: bool,
) -> Iterator[Companion]:
    """A companion that waits for ground stations, and everything that its flights need.

    Args:
        mission: what they may start before they have sent another mission; None if nothing.
        folders: where the flights are recorded.
        options: how missions are flown.
        page: the monitor page.
        memory: what is remembered of earlier flights.
        cut_off: the run to resume before any other is started, if there is one; of this mission.
        has_reports: whether other programs on board can report events.
    """
    installed = read_all()
    with (
        closing(FunctionRunner()) as functions,
        closing(CheckChildren(installed, has_reports)) as children,
        closing(Uploads(folders.log_dir / UPLOADS, children.begin)) as uploads,
        closing(SortieHost(folders, page, uploads, functions, options.engine, installed)) as host,
    ):
        first = None
        if cut_off is not None:
            first = OnlyRun(
                cut_off.mission,
                host.resume_run(cut_off),
                engine=options.engine,
                functions=functions,
                journalled=cut_off.journalled,
            )
        functions.prepare(functions_of(mission) if mission is not None else ())
        runs = HostedRuns(host, mission, first)
        yield Companion(runs, options.terms, page=page, memory=memory)
