"""What operators may request of the companion, and what the companion reports about itself.

The component (`component.py`) speaks MAVLink with ground stations; the code that flies implements
`Operations`. Each request is answered at once: with None if it is done, or with a `Refusal`.
Missions from outside come through the `UploadService`, which has the files and the checks; the
monitor page is a `MonitorPage`.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from pathlib import Path
from typing import Protocol

from companion.acting.sortie.phases import ON_THE_GROUND
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
        """The status in a phase of a sortie; after its end, it depends on whether the sortie
        failed.
        """
        if phase is Phase.YIELDED or (phase is Phase.ENDED and has_failed):
            return cls.CRITICAL
        return cls.STANDBY if phase in (*ON_THE_GROUND, Phase.ENDED) else cls.ACTIVE


class Operations(Protocol):
    """The requests that an operator can make."""

    @property
    def system_status(self) -> SystemStatus:
        """The present status."""

    @property
    def awaited(self) -> frozenset[str]:
        """The MAV_CMD names that the mission's events wait for."""

    def start(self) -> Refusal | None:
        """Flies the mission, from the ground."""

    def pause(self) -> Refusal | None:
        """Holds in the air; the task is frozen."""

    def resume(self) -> Refusal | None:
        """Resumes after a pause, or after the pilot has handed over control."""

    def return_home(self) -> Refusal | None:
        """Drops the task, flies home and lands; or does what the mission defines instead."""


class MonitorPage(Protocol):
    """The monitor page, in its own process. No call may block."""

    @property
    def is_served(self) -> bool:
        """Whether the page is served; it may end by itself."""

    def switch(self, is_on: bool) -> str:
        """Starts or ends it, if possible; returns a line for people: its address, or why not."""


class UploadService(Protocol):
    """Missions that come over MAVLink FTP. No call may block."""

    @property
    def has_waiting(self) -> bool:
        """Whether an accepted mission waits until nothing is flown."""

    def ftp(self, now_s: float, client: tuple[int, int], payload: bytes) -> list[bytes]:
        """Returns the replies to a FILE_TRANSFER_PROTOCOL payload of a (system, component)."""

    def poll(self, now_s: float, is_flying: bool) -> Sequence[UploadVerdict]:
        """Returns the new verdicts; a mission accepted in flight waits for the landing."""

    def take_active(self) -> Path | None:
        """Makes the accepted mission the active one; to be called only while nothing is flown."""

    def started(self) -> None:
        """Notes that the active mission is started, so that it is not offered again."""
