"""Waits until an intention is on the disk, so that nothing is done twice after a crash."""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.outcomes import Failed, Outcome, Progress

DISK_S = 10.0
"""The longest time until an intention is on the disk."""


def kept(flight: Flight, intended_s: float) -> Outcome:
    """DONE once everything noted in the journal is on the disk; a failure after `DISK_S`.

    Args:
        flight: the flight with the journal.
        intended_s: when the intention was noted.
    """
    if flight.journal.is_kept:
        return Progress.DONE
    is_late = flight.now_s - intended_s > DISK_S
    return Failed("the journal does not reach the disk") if is_late else Progress.RUNNING
