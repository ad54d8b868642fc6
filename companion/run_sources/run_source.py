"""Where a companion's runs come from, one after the other."""

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
    """Gives a companion what it flies. No call may block."""

    @property
    def uploads(self) -> UploadService | None:
        """Missions from outside; None where none are taken."""

    @property
    def is_over(self) -> bool:
        """Whether no run comes after what was given so far."""

    @property
    def awaits_start(self) -> bool:
        """Whether an operator has to start what is flown next."""

    def missing(self, telemetry: Telemetry) -> str | None:
        """What the next run waits to hear of its vehicle, in words; None if nobody waits for it."""

    def start(self, telemetry: Telemetry, now_s: float, speed_max_mps: float) -> Refusal | None:
        """An operator starts the next run; nothing is flown.

        Args:
            telemetry: of the vehicle.
            now_s: the flight's time.
            speed_max_mps: what the operator allows.
        """

    def next(self, telemetry: Telemetry, now_s: float) -> PreparedRun | CompanionError | None:
        """The run that begins now, or why it cannot begin; None if none does. Nothing is flown."""

    def end(self, recorder: Recorder) -> None:
        """A run has ended, and is not the last one."""

    def news(self, now_s: float, is_flying: bool) -> Sequence[FlightEvent]:
        """What has become of missions from outside, and of what was started."""

    def tell(self, stamped: Stamped) -> None:
        """Keeps an event that is of no run."""
