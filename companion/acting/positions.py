"""Reports the positions of the word that the flight has left, and what they violate."""

from __future__ import annotations

from collections.abc import Iterable

from companion.acting.flight import Flight
from companion.flight_events.word import ConjunctViolated, PositionLeft
from companion.planning.lasso import Conjunct


def tell_late(flight: Flight) -> None:
    """Reports each bounded line whose clock has just run out."""
    tell_overrun(flight, flight.task.run_clocks(flight.now_s).over)


def tell_overrun(flight: Flight, late: Iterable[Conjunct]) -> None:
    """Reports the bounded lines that have become late since the last position was left."""
    task = flight.task
    for conjunct in late:
        _tell_violated(flight, conjunct, task.word.last_position, tuple(sorted(task.facts)))


def tell_positions(flight: Flight, for_ever: bool = False) -> None:
    """Reports the positions that were left since the last call, and what they violate.

    Args:
        for_ever: whether the vehicle rests there, so that all later positions are the same.
    """
    for position in flight.task.word.left:
        number, facts = position.number, tuple(sorted(position.facts))
        left = PositionLeft(
            number,
            facts,
            risen=tuple(sorted(position.risen)),
            reached_s=round(position.reached_s, 3),
            withdrawn=tuple(sorted(position.withdrawn)),
            restarted=position.restarted,
            for_ever=for_ever,
            dropped=position.dropped,
        )
        flight.report(left)
        for conjunct in position.violated:
            _tell_violated(flight, conjunct, number, facts)
    flight.task.word.left.clear()


def _tell_violated(flight: Flight, conjunct: Conjunct, number: int, facts: tuple[str, ...]) -> None:
    is_optional = conjunct.name in flight.task.lines.optional
    flight.report(ConjunctViolated(conjunct.name, conjunct.text, number, facts, is_optional))
