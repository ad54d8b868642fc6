"""The interface by which a companion gets its runs, one after the other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from companion.errors import CompanionError
from companion.flight_events.event import FlightEvent, Stamped
from companion.ground.operations import UploadService
from companion.mission_run import PreparedRun, Recorder
from companion.outcomes import Refusal
from companion.vehicle.telemetry import Telemetry


class RunSource(Protocol):
    """Gives a companion the runs to fly. No call may block."""

    @property
    def uploads(self) -> UploadService | None:
        """Missions from outside; None if they are not accepted."""

    @property
    def is_over(self) -> bool:
        """Whether no further run will come."""

    @property
    def awaits_start(self) -> bool:
        """Whether an operator has to start the next run."""

    @property
    def has_newer(self) -> bool:
        """Whether a mission was accepted that will not be flown by the run that was started."""

    def missing(self, telemetry: Telemetry) -> str | None:
        """What the next run waits to hear of its vehicle, in words; None if nobody waits for it."""

    def start(self, telemetry: Telemetry, now_s: float, speed_max_mps: float) -> Refusal | None:
        """Starts the next run, on an operator's request, while nothing is flown.

        Args:
            telemetry: of the vehicle.
            now_s: the flight's time.
            speed_max_mps: the operator's speed limit.
        """

    def next(self, telemetry: Telemetry, now_s: float) -> PreparedRun | CompanionError | None:
        """The run that begins now, or why it cannot begin; None if none does. Nothing is flown."""

    def end(self, recorder: Recorder) -> None:
        """Notes that a run has ended that is not the last one."""

    def news(self, now_s: float, is_flying: bool) -> Sequence[FlightEvent]:
        """What became of missions from outside, and of what was started."""

    def tell(self, stamped: Stamped) -> None:
        """Keeps an event that belongs to no run."""
