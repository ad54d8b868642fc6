"""What became of something that takes time: it is running, is done, or has failed for a reason."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Progress(Enum):
    """A goal or a command that has not failed."""

    RUNNING = "running"
    DONE = "done"


@dataclass(frozen=True, slots=True)
class Failed:
    """A goal was not reached, or a command not done; the reason is in words."""

    reason: str


Outcome = Progress | Failed
"""What became of a goal or a command."""
