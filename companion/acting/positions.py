"""Which positions of the word has the flight left, and what do they violate? Told as reports."""

from __future__ import annotations

from companion.acting.flight import Flight


def tell_positions(flight: Flight, for_ever: bool = False) -> None:
    """Reports the positions that were left since the last call, and what they violate.

    Args:
        for_ever: the vehicle rests there, and every position to come is the same.
    """
    for position in flight.task.left:
        number, facts = position.number, sorted(position.facts)
        flight.report(
            "position",
            f"position {number}: {', '.join(facts)}",
            number=number,
            facts=facts,
            withdrawn=sorted(position.withdrawn),
            restarted=list(position.restarted),
            for_ever=for_ever,
        )
        for conjunct in position.violated:
            flight.report(
                "violation",
                f"{conjunct.name} violated at position {number}: {conjunct.formula}",
                conjunct=conjunct.name,
                formula=str(conjunct.formula),
                position=number,
                facts=facts,
            )
    flight.task.left.clear()
