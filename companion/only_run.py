"""The run of a companion that flies one mission and then ends, before it begins."""

from __future__ import annotations

from dataclasses import dataclass

from companion.acting.function_port import FunctionPort
from companion.acting.journal import JournalledFlight
from companion.acting.preparation import PreparedMission, prepare
from companion.errors import Aborted, MissionError
from companion.flight_events.event import Stamped
from companion.flight_events.sortie import RunFailed
from companion.mission.model import Mission
from companion.mission_run import Recorder
from companion.planning.engine_port import Engine
from companion.vehicle.telemetry import Telemetry


@dataclass(frozen=True)
class OnlyRun:
    """The only run of a companion, before it begins.

    Attributes:
        recorder: of it.
        engine: who plans it; None for the built-in search.
        functions: calls functions of installed packages; None where nothing does.
        journalled: a run that was cut off, to go on with.
    """

    mission: Mission
    recorder: Recorder
    engine: Engine | None
    journalled: JournalledFlight | None
    functions: FunctionPort | None = None

    @classmethod
    def of(
        cls,
        mission: Mission | None,
        recorder: Recorder | None,
        engine: Engine | None,
        journalled: JournalledFlight | None,
        functions: FunctionPort | None,
    ) -> OnlyRun | None:
        """The only run of a mission with a recorder; None for a companion that hosts."""
        if mission is None or recorder is None:
            return None
        return cls(mission, recorder, engine, journalled, functions)

    def prepare(self, telemetry: Telemetry) -> PreparedMission | Aborted | None:
        """Its preparation, or why it cannot begin; None until all that it needs was heard.

        A mission with places above the sea needs the height of the ground. One whose vehicle does
        not stand there is prepared without: the run leaves the vehicle alone.
        """
        seen = self.journalled.seen if self.journalled is not None else None
        ground_amsl_m = seen.altitude_m if seen is not None else telemetry.ground_amsl_m
        if self.mission.is_above_sea and ground_amsl_m is None and not telemetry.is_flown:
            return None
        try:
            return prepare(
                self.mission,
                engine=self.engine,
                ground_amsl_m=ground_amsl_m,
                functions=self.functions,
            )
        except MissionError as error:
            failure = Aborted(str(error))
            self.recorder.report(Stamped(0.0, RunFailed(str(failure), failure.exit_code)))
            return failure
