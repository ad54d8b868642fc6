"""The interface to the program that hosts a companion which flies several sorties."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

from companion.acting.preparation import Preparation
from companion.flight_events.event import Stamped
from companion.ground.operations import UploadService
from companion.mission.model import Mission
from companion.mission_run import Recorder


class Host(Protocol):
    """Keeps the files of a companion that flies several sorties, and does the slow work."""

    @property
    def uploads(self) -> UploadService | None:
        """Missions from outside."""

    def load(self, path: Path) -> Mission:
        """Reads a mission that was accepted.

        Raises:
            CompanionError, OSError: it cannot be read after all.
        """

    def prepare(
        self, mission: Mission, speed_max_mps: float, ground_amsl_m: float | None
    ) -> Preparation:
        """Begins to prepare a mission, as `preparation.prepare` does. It may not block."""

    def begin_run(self, mission: Mission) -> Recorder:
        """Returns a recorder for another run.

        Raises:
            OSError: the recorder cannot be made.
        """

    def end_run(self, recorder: Recorder) -> None:
        """Closes the record of a run that has ended. It may not block."""

    def tell(self, stamped: Stamped) -> None:
        """Reports an event between two runs."""
