"""What a companion that flies several sorties asks of the program that it lives in."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

from companion.acting.preparation import Preparation
from companion.flight_events.event import Stamped
from companion.ground.operations import UploadService
from companion.mission.model import Mission
from companion.mission_run import Recorder


class Host(Protocol):
    """Keeps the files of a companion that flies several sorties, and does what takes long."""

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
        """A recorder for one more run.

        Raises:
            OSError: there is none.
        """

    def end_run(self, recorder: Recorder) -> None:
        """A run has ended. It may not block."""

    def tell(self, stamped: Stamped) -> None:
        """News between two runs."""
