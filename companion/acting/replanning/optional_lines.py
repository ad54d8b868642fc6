"""Lines of the task that may be dropped, in flight: which of them plans keep, and when more can be.

Which lines are kept is chosen with each new plan. A plan that does not keep all of them is in use
until it fails; each time when a skill was completed it is asked whether a line can be taken up
again, before the next skill begins.
"""

from __future__ import annotations

from companion.acting.flight import Flight
from companion.acting.replanning.search_in_parts import SearchInParts
from companion.flight_events.plans import LineDropped, LineTakenUp
from companion.planning.lasso import DroppedLine, Problem
from companion.planning.planner import Planner

LED_NOWHERE = "several plans in a row led nowhere"


class OptionalLines:
    """Knows which lines to drop.

    Args:
        planner: of the mission.
        flight: from where plans are made.
    """

    def __init__(self, planner: Planner, flight: Flight) -> None:
        self._planner = planner
        self._flight = flight
        self._dropping: SearchInParts[tuple[DroppedLine, ...]] | None = None
        self._taking_up: SearchInParts[tuple[str, ...]] | None = None

    def is_outdated_by(self, problem: Problem) -> bool:
        """Whether what is searched for is not about a problem, which differs in more than costs."""
        return self._dropping is not None and not self._dropping.is_about(problem)

    def abandon(self) -> None:
        """Nobody asks any more which lines to drop."""
        self._dropping = self._taking_up = None

    @property
    def all_in_vain(self) -> tuple[DroppedLine, ...]:
        """All of them, to be dropped where plans led nowhere."""
        return tuple(DroppedLine(line, LED_NOWHERE) for line in self._planner.mission.optional)

    def choose(self, problem: Problem) -> tuple[DroppedLine, ...] | None:
        """The lines that a new plan has to drop; None until it is known.

        Args:
            problem: with all lines.
        """
        if self._dropping is None:
            self._dropping = SearchInParts(problem, self._planner.dropping(problem))
        return self._dropping.step()

    def look(self) -> str | None:
        """The part of a tick of asking whether a dropped line can be kept; which one can be."""
        task = self._flight.task
        problem, _ = task.problem()
        if self._taking_up is None or not self._taking_up.is_about(problem):
            parts = self._planner.taking_up(problem, task.dropped)
            self._taking_up = SearchInParts(problem, parts)
        lines = self._taking_up.step()
        if lines is None:
            return None
        self._taking_up = None
        task.keep_dropped()
        return next(iter(lines), None)


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
