"""Lines of the task that may be dropped, in flight: which of them the plan keeps from now on.

Which lines are kept is chosen with each new plan. A plan that does not keep all of them is in use
until it fails; each time when a skill was completed it is asked whether a line can be taken up
again.
"""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.flight_events.plans import LineDropped, LineTakenUp
from companion.planning.lasso import DroppedLine

LED_NOWHERE = "several plans in a row led nowhere"


def drop(flight: Flight, dropped: tuple[DroppedLine, ...]) -> None:
    """The plan from now on drops these lines and keeps all others; reports what is new in that."""
    before = flight.task.dropped
    now = [each.line for each in dropped]
    anew = flight.task.drop(now)
    for each in dropped:
        if each.line not in before:
            flight.report(LineDropped(each.line, each.reason))
    for line in sorted({*anew, *before.difference(now)}):
        flight.report(LineTakenUp(line, line in anew))
