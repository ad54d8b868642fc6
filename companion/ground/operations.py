"""What an operator may ask of the companion, and what the companion tells of itself.

The component (`component.py`) speaks MAVLink with ground stations; whoever flies fulfils
`Operations`. Each request is answered at once: with None if it is done, or with a `Refusal`.
Missions from outside come through the `UploadService`, which has the files and the checks; the
monitor page is a `MonitorPage`.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from pathlib import Path
from typing import Protocol

from companion.acting.phases import ON_THE_GROUND
from companion.flight_events.sortie import Phase
from companion.ground.upload_states import UploadVerdict
from companion.outcomes import Refusal


class SystemStatus(Enum):
    """The companion's HEARTBEAT.system_status (MAV_STATE)."""

    STANDBY = "nothing is flown"
    ACTIVE = "a sortie is flown"
    CRITICAL = "the last sortie failed, or control is lost"

    @classmethod
    def of(cls, phase: Phase, has_failed: bool) -> SystemStatus:
        """That of a phase of a sortie; after its end, of whether it has failed."""
        if phase is Phase.YIELDED or (phase is Phase.ENDED and has_failed):
            return cls.CRITICAL
        return cls.STANDBY if phase in (*ON_THE_GROUND, Phase.ENDED) else cls.ACTIVE


class Operations(Protocol):
    """What an operator can ask of the companion."""

    @property
    def system_status(self) -> SystemStatus:
        """The present status."""

    @property
    def awaited(self) -> frozenset[str]:
        """The MAV_CMD names that the mission's events wait for."""

    def start(self) -> Refusal | None:
        """Flies the mission, from the ground."""

    def pause(self) -> Refusal | None:
        """Holds in the air, the task frozen."""

    def resume(self) -> Refusal | None:
        """Goes on after a pause, or with control that the pilot has handed over."""

    def return_home(self) -> Refusal | None:
        """Leaves the task, flies home and lands; or does what the mission has for that."""


class MonitorPage(Protocol):
    """The monitor page, in a process of its own. No call may block."""

    @property
    def is_served(self) -> bool:
        """Whether the page is served; it may end by itself."""

    def switch(self, is_on: bool) -> str:
        """Serves it or ends it, if it can; returns a line for people: its address, or why not."""


class UploadService(Protocol):
    """Missions that come over MAVLink FTP. No call may block."""

    def ftp(self, now_s: float, client: tuple[int, int], payload: bytes) -> list[bytes]:
        """Returns the replies to a FILE_TRANSFER_PROTOCOL payload of a (system, component)."""

    def poll(self, now_s: float, is_flying: bool) -> Sequence[UploadVerdict]:
        """Returns the new verdicts; what is accepted in flight waits for the landing."""

    def take_active(self) -> Path | None:
        """Makes the accepted mission the active one; called only while nothing is flown."""

    def started(self) -> None:
        """The active mission is started, and need not be offered again."""
