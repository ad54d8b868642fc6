"""Outcomes of requests as values: an expected failure is no exception.

A function that does what it is asked, or declines, returns `Refusal | None`; None means done. What
takes time is running, done or failed: an `Outcome`, or a result in place of DONE.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


@dataclass(frozen=True, slots=True)
class Refusal:
    """What was asked for is not done.

    Attributes:
        reason: in words for people.

    >>> def pause(is_flying: bool) -> Refusal | None:
    ...     return None if is_flying else Refusal("nothing is flown")
    >>> if refusal := pause(is_flying=False):
    ...     print(refusal.reason)
    nothing is flown
    """

    reason: str


class Progress(Enum):
    """Something that takes time and has not failed."""

    RUNNING = "running"
    DONE = "done"


@dataclass(frozen=True, slots=True)
class Failed:
    """Something that takes time has failed.

    Attributes:
        reason: in words for people.
    """

    reason: str


Outcome = Progress | Failed
"""What became of a goal, a command, or a movement of a gimbal."""
