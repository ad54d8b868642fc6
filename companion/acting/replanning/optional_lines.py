"""Applies, in flight, which optional lines of the task the new plan keeps.

Each new plan decides again which lines are kept. A plan that does not keep all of them is used
until it fails. After each completed skill, it is checked whether a dropped line can be kept again.
"""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.flight_events.plans import LineDropped, LineTakenUp
from companion.planning.lasso import DroppedLine

LED_NOWHERE = "several plans in a row led nowhere"


def drop(flight: Flight, dropped: tuple[DroppedLine, ...]) -> None:
    """From now on drops these lines and keeps all others; reports the changes."""
    before = flight.task.lines.dropped
    now = [each.line for each in dropped]
    anew = flight.task.drop(now)
    for each in dropped:
        if each.line not in before:
            flight.report(LineDropped(each.line, each.reason))
    for line in sorted({*anew, *before.difference(now)}):
        flight.report(LineTakenUp(line, line in anew))
