"""A mission that is flown once: over a link or in lockstep, from a command or from Python."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from companion.acting.journal import JournalledFlight
from companion.app import Companion
from companion.errors import LinkError
from companion.flight_events.event import Stamped
from companion.flight_events.sortie import RunFailed
from companion.flights.options import FlightOptions
from companion.ground.operations import MonitorPage
from companion.mission.model import Mission
from companion.mission_run import Recorder
from companion.run_sources.only_run import OnlyRun
from companion.skills.runner import FunctionRunner
from companion.vehicle.flight_memory import FlightMemory


@contextmanager
def only_flight(
    mission: Mission,
    recorder: Recorder,
    options: FlightOptions,
    *,
    folder: Path | None,
    page: MonitorPage | None = None,
    memory: FlightMemory | None = None,
    journalled: JournalledFlight | None = None,
    is_lockstep: bool = False,
) -> Iterator[Companion]:
    """A companion that flies one mission, and the processes of the functions that it calls.

    A flight that found no vehicle is recorded with its end, too, unless it would resume another
    one, which can then be resumed again.

    Args:
        mission: the mission to fly.
        recorder: records the flight; closed by its owner, later.
        options: how the mission is flown.
        folder: the run folder; None if there is none.
        page: the monitor page, if there is one.
        memory: what is remembered of earlier flights.
        journalled: the flight that was cut off, if this one resumes it.
        is_lockstep: whether the flight's time waits for the functions.
    """
    with closing(FunctionRunner(folder, is_lockstep)) as functions:
        run = OnlyRun(
            mission, recorder, engine=options.engine, functions=functions, journalled=journalled
        )
        companion = Companion(run, options.terms, page=page, memory=memory)
        try:
            yield companion
        except LinkError as error:
            if journalled is None:
                ending = RunFailed(str(error), error.exit_code)
                recorder.report(Stamped(round(companion.now_s, 3), ending))
            raise
