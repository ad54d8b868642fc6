"""What may an operator ask of the companion, and what does the companion tell of itself?

The component (`component.py`) speaks MAVLink with ground stations; whoever flies fulfils
`Operations`. Each request is answered at once: with "" if it is done, or why it is not, in words
for people. Missions from outside come through `Uploads`, which has the files and the checks; the
monitor page is a `Page`.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum
from pathlib import Path
from typing import Protocol

from companion.ground.upload_states import UploadVerdict


class Standing(Enum):
    """How the companion stands, as far as ground stations care."""

    STANDBY = "nothing is flown"
    ACTIVE = "a sortie is flown"
    CRITICAL = "the last sortie failed, or control is lost"


class Operations(Protocol):
    """Whoever flies."""

    @property
    def standing(self) -> Standing:
        """How it stands now."""

    @property
    def awaited(self) -> frozenset[str]:
        """MAV_CMD names that the mission's events wait for."""

    def start(self) -> str:
        """Fly the mission, from the ground."""

    def pause(self) -> str:
        """Hold in the air, the task frozen."""

    def go_on(self) -> str:
        """Go on after a pause, or with control that the pilot has handed over."""

    def go_home(self) -> str:
        """Leave the task, fly home and land; or what the mission has for that."""


class Page(Protocol):
    """The monitor page, in a process of its own. No call may block."""

    @property
    def is_served(self) -> bool:
        """Whether it is there; it may end by itself."""

    def switch(self, is_on: bool) -> str:
        """Serves it or ends it, if it can; a line for people, where it is or why it is not."""


class UploadService(Protocol):
    """Missions that come over MAVLink FTP. No call may block."""

    def ftp(self, now_s: float, client: tuple[int, int], payload: bytes) -> list[bytes]:
        """The replies to a FILE_TRANSFER_PROTOCOL payload of a (system, component)."""

    def poll(self, now_s: float, is_flying: bool) -> Sequence[UploadVerdict]:
        """Returns the new verdicts; what is accepted in flight waits for the landing."""

    def take_active(self) -> Path | None:
        """Makes the accepted mission the active one; called only while nothing is flown."""

    def started(self) -> None:
        """The active mission is started, and need not be offered again."""
