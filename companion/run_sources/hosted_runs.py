"""The runs that operators start, one after the other, for as long as the program runs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from companion.acting.preparation import Preparation
from companion.acting.sortie.authority import why_left_alone
from companion.errors import CompanionError
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.hosting import MissionReady, MissionUnreadable, RunNotBegun
from companion.ground.operations import UploadService
from companion.mission.model import Mission
from companion.mission_run import PreparedRun, Recorder
from companion.outcomes import Refusal
from companion.run_sources.host import Host
from companion.run_sources.only_run import OnlyRun
from companion.vehicle.telemetry import Telemetry


class HostedRuns:
    """A `RunSource` that flies the newest mission each time MISSION_START requests it.

    A started mission is prepared while the companion continues to work. Its run begins in a step of
    its own, after the answer to the command was sent.

    Args:
        host: makes and ends runs, and reads missions.
        mission: the mission that operators may start; None to wait for an upload.
        first: a run that was cut off; it continues before others are started.

    Attributes:
        is_over: always False: another run may be started at any time.
    """

    is_over = False

    def __init__(
        self, host: Host, mission: Mission | None = None, first: OnlyRun | None = None
    ) -> None:
        self._host, self._mission, self._first = host, mission, first
        self._preparation: Preparation | None = None
        self._news: list[FlightEvent] = []

    @property
    def uploads(self) -> UploadService | None:
        """The host's uploads."""
        return self._host.uploads

    @property
    def awaits_start(self) -> bool:
        """Whether nothing was started, or it is still being prepared."""
        is_prepared = self._preparation is not None and self._preparation.done()
        return self._first is None and not is_prepared

    @property
    def has_newer(self) -> bool:
        """Whether an upload was accepted since a mission was started."""
        return self.uploads is not None and self.uploads.has_waiting

    def missing(self, telemetry: Telemetry) -> None:
        """None: nobody waits for the vehicle, which may come at any time."""

    def start(self, telemetry: Telemetry, now_s: float, speed_max_mps: float) -> Refusal | None:
        """Begins to prepare the newest mission; a run that was cut off continues by itself."""
        if self.has_newer:
            return Refusal("another mission was started before; the newest is flown after it")
        if self._first is not None:
            return None
        if self._mission is None:
            return Refusal("there is no mission; upload one")
        if refusal := why_left_alone(telemetry.state, now_s):
            return refusal
        if self._preparation is None:
            ground_amsl_m = telemetry.ground_amsl_m
            self._preparation = self._host.prepare(self._mission, speed_max_mps, ground_amsl_m)
        return None

    def next(self, telemetry: Telemetry, now_s: float) -> PreparedRun | None:
        """The started run, once it is prepared, if the vehicle still allows it to begin."""
        match self._cut_off(telemetry, now_s) or self._prepared(telemetry, now_s):
            case PreparedRun() as run:
                return replace(run, may_yield=True)
            case Refusal(reason):
                self._news.append(RunNotBegun(reason))
        return None

    def end(self, recorder: Recorder) -> None:
        """Lets the host close the record."""
        self._host.end_run(recorder)

    def news(self, now_s: float, is_flying: bool) -> list[FlightEvent]:
        """What became of uploads; an accepted one is read while nothing is flown or prepared.

        The host learns only when a run begins which mission was started. So an upload that
        arrives while a mission is being prepared waits as well.
        """
        if (uploads := self.uploads) is not None:
            is_busy = is_flying or self._preparation is not None or self._first is not None
            for verdict in uploads.poll(now_s, is_busy):
                self._news += verdict.news
            if not is_busy and (path := uploads.take_active()) is not None:
                self._news.append(self._take(path))
        news, self._news = self._news, []
        return news

    def tell(self, stamped: Stamped) -> None:
        """Lets the host report an event."""
        self._host.tell(stamped)

    def _take(self, path: Path) -> FlightEvent:
        try:
            self._mission = self._host.load(path)
        except (CompanionError, OSError) as error:
            return MissionUnreadable(str(error))
        return MissionReady(self._mission.name)

    def _cut_off(self, telemetry: Telemetry, now_s: float) -> PreparedRun | Refusal | None:
        """The run that was cut off, once everything that it needs was heard."""
        if (first := self._first) is None:
            return None
        run = first.next(telemetry, now_s)
        if run is not None:
            self._first = None
        if isinstance(run, CompanionError):
            self._host.end_run(first.recorder)
            return Refusal(str(run))
        return run

    def _prepared(self, telemetry: Telemetry, now_s: float) -> PreparedRun | Refusal | None:
        """The started run; or why there is none."""
        if (preparation := self._preparation) is None or not preparation.done():
            return None
        self._preparation = None
        if refusal := why_left_alone(telemetry.state, now_s):
            return refusal
        try:
            prepared = preparation.result()
        except CompanionError as error:
            return Refusal(str(error))
        try:
            return PreparedRun(prepared, self._host.begin_run(prepared.mission))
        except OSError as error:
            return Refusal(f"no run folder: {error}")
