"""What is intended is on the disk before it is done, so nothing is done twice after a crash."""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.vehicle.port import Failed, Outcome, Progress

DISK_S = 10.0
"""Time in which what is intended has to be on the disk."""


def kept(flight: Flight, intended_s: float) -> Outcome:
    """DONE once all that was noted in the journal is on the disk; a failure after `DISK_S`.

    Args:
        flight: whose journal it is.
        intended_s: when it was noted.
    """
    if flight.journal.is_kept:
        return Progress.DONE
    is_late = flight.now_s - intended_s > DISK_S
    return Failed("the journal does not reach the disk") if is_late else Progress.RUNNING
