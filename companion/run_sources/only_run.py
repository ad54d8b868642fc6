"""The run of a companion that flies one mission and then ends, before it begins."""

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
    """A `RunSource` with one run, which begins as soon as all that it needs was heard.

    Args:
        mission: what is flown.
        recorder: told of everything that happens in it.
        engine: who plans it; None for the built-in search.
        functions: calls functions of installed packages; None where nothing does.
        journalled: a run that was cut off, to go on with; the mission is its own.

    Attributes:
        uploads: none are taken.
        is_over: it was given, or cannot begin.
        awaits_start: nobody has to start it.
    """

    uploads = None
    awaits_start = False

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
        """All that its vehicle has not told."""
        return telemetry.missing

    def start(self, telemetry: Telemetry, now_s: float, speed_max_mps: float) -> Refusal | None:
        """It begins by itself, if it can."""
        return Refusal("its only mission cannot begin") if self.is_over else None

    def next(self, telemetry: Telemetry, now_s: float) -> PreparedRun | Aborted | None:
        """Prepares it.

        A mission with places above the sea needs the height of the ground. One whose vehicle does
        not stand there is prepared without: the run leaves the vehicle alone.
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
        """Its owner closes the record."""

    def news(self, now_s: float, is_flying: bool) -> list[FlightEvent]:
        """None."""
        return []

    def tell(self, stamped: Stamped) -> None:
        """Its record begins with the run."""
