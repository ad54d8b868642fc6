"""What has become of something that takes time: it is running, done, or has failed for a reason."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Progress(Enum):
    """How far a goal or a command has come that has not failed."""

    RUNNING = "running"
    DONE = "done"


@dataclass(frozen=True, slots=True)
class Failed:
    """A goal is not reached, or a command not done, for a reason in words."""

    reason: str


Outcome = Progress | Failed
"""What has become of a goal or a command."""
