"""The run of a companion that flies one mission and then ends, until the run begins."""

from __future__ import annotations

from companion.acting.function_port import FunctionPort
from companion.acting.journal import JournalledFlight
from companion.acting.preparation import prepare
from companion.errors import Aborted, MissionError
from companion.flight_events.event import FlightEvent, Stamped
from companion.flight_events.sortie import RunFailed
from companion.mission.model import Mission
from companion.mission_run import PreparedRun, Recorder
from companion.outcomes import Refusal
from companion.planning.engine_port import Engine
from companion.vehicle.telemetry import Telemetry


class OnlyRun:
    """A `RunSource` with one run, which begins as soon as everything that it needs was heard.

    Args:
        mission: the mission to fly.
        recorder: receives everything that happens in the run.
        engine: plans the mission; None for the built-in search.
        functions: calls functions of installed packages; None if nothing does.
        journalled: a run that was cut off, to be continued; it has the same mission.

    Attributes:
        uploads: always None: uploads are not accepted.
        is_over: whether the run was handed out, or cannot begin.
        awaits_start: always False: nobody has to start it.
        has_newer: always False.
    """

    uploads = None
    awaits_start = has_newer = False

    def __init__(
        self,
        mission: Mission,
        recorder: Recorder,
        *,
        engine: Engine | None = None,
        functions: FunctionPort | None = None,
        journalled: JournalledFlight | None = None,
    ) -> None:
        self.is_over = False
        self.recorder = recorder
        self._mission, self._engine, self._functions = mission, engine, functions
        self._journalled = journalled

    def missing(self, telemetry: Telemetry) -> str:
        """What still has to be heard of the vehicle."""
        return telemetry.missing

    def start(self, telemetry: Telemetry, now_s: float, speed_max_mps: float) -> Refusal | None:
        """Refuses if the run cannot begin; otherwise it begins by itself."""
        return Refusal("its only mission cannot begin") if self.is_over else None

    def next(self, telemetry: Telemetry, now_s: float) -> PreparedRun | Aborted | None:
        """Prepares the run.

        A mission with altitudes above the sea needs the altitude of the ground. If its vehicle is
        armed or in the air, it is prepared without: the run leaves the vehicle alone.
        """
        seen = self._journalled.seen if self._journalled is not None else None
        ground_amsl_m = seen.altitude_m if seen is not None else telemetry.ground_amsl_m
        if self._mission.is_above_sea and ground_amsl_m is None and not telemetry.is_flown:
            return None
        self.is_over = True
        try:
            prepared = prepare(
                self._mission,
                engine=self._engine,
                ground_amsl_m=ground_amsl_m,
                functions=self._functions,
            )
        except MissionError as error:
            failure = Aborted(str(error))
            self.recorder.report(Stamped(0.0, RunFailed(str(failure), failure.exit_code)))
            return failure
        return PreparedRun(prepared, self.recorder, self._journalled)

    def end(self, recorder: Recorder) -> None:
        """Does nothing: the owner of the record closes it."""

    def news(self, now_s: float, is_flying: bool) -> list[FlightEvent]:
        """No events."""
        return []

    def tell(self, stamped: Stamped) -> None:
        """Does nothing: the record begins with the run."""
