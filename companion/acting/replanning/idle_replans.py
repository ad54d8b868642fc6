"""Counts replans that lead nowhere: those between which no skill was completed.

Replans for events do not count, because the plan before was not wrong; searches that begin anew do.
"""

from __future__ import annotations

from companion.acting.flight import Flight

MAX_IDLE_REPLANS = 5
"""Replans without a completed skill in between, before all optional lines are in doubt."""


class IdleReplans:
    """The replans since a skill was completed.

    Attributes:
        number: how many there were.
        failed: the skills that failed in their plans, with `*` for where they began.

    Args:
        flight: knows the progress of plan and task.
    """

    def __init__(self, flight: Flight) -> None:
        self.number = 0
        self.failed = frozenset[str]()
        self._flight = flight
        self._completed = 0

    def count(self) -> None:
        """Counts a replan, and notes the skill that has failed."""
        completed, failed = self._flight.task.completed, self._flight.progress.failed
        if completed > self._completed:
            self.number, self.failed = 0, frozenset()
        else:
            self.number += 1
        if failed is not None:
            self.failed |= {failed.from_anywhere}
        self._completed = completed

    def reset(self) -> None:
        """Forgets them, because the operator wants to continue, or something has changed."""
        self.number, self.failed = 0, frozenset()

    @property
    def are_too_many(self) -> bool:
        """Whether another plan like those before would hardly lead anywhere."""
        return self.number >= MAX_IDLE_REPLANS
