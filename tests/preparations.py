"""A preparation without a thread: it is done when it has been asked so often."""

from __future__ import annotations

from companion.acting.preparation import PreparedMission, prepare
from companion.mission.model import Mission


class Polled:
    """A `preparation.Preparation`.

    Args:
        mission: what is prepared.
        speed_max_mps: what an operator allows.
        polls: how often it is not done yet.
    """

    def __init__(self, mission: Mission, speed_max_mps: float, polls: int = 0) -> None:
        self._mission, self._speed_max_mps = mission, speed_max_mps
        self._polls = polls

    def done(self) -> bool:
        self._polls -= 1
        return self._polls < 0

    def result(self) -> PreparedMission:
        return prepare(self._mission, self._speed_max_mps)
