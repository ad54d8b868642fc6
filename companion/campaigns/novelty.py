"""Which flights of a search are of one kind: the same things happened, in the same order.

The search prefers flights of a kind that it has seen less often, where their margins are equal
(search.py). Times, positions and reasons are left out: they differ between any two flights.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable

from companion.flight_events.event import FlightEvent
from companion.flight_events.plans import LineDropped, LineTakenUp, NoPlanFound, PlanReplaced
from companion.flight_events.skills import SkillFailed, WrittenTreeFailed
from companion.flight_events.sortie import (
    BatteryLow,
    ControlYielded,
    GoalFailed,
    LinkSilent,
    PhaseEntered,
    ReturnBegun,
    ReturnFailed,
    SetpointRefused,
    VehicleCrashed,
)
from companion.flight_events.word import ConjunctViolated

BY_TYPE = (
    BatteryLow
    | ControlYielded
    | GoalFailed
    | LinkSilent
    | NoPlanFound
    | PlanReplaced
    | ReturnBegun
    | ReturnFailed
    | SetpointRefused
    | VehicleCrashed
    | WrittenTreeFailed
)
"""Events that are equal here if their type is."""


def signature(events: Iterable[FlightEvent]) -> str:
    """A hash of the kind of a flight.

    >>> failed, again = SkillFailed("photo(A)", "refused"), SkillFailed("photo(A)", "no answer")
    >>> signature([failed]) == signature([again])
    True
    >>> signature([failed]) == signature([failed, again])
    False
    """
    told = [words for event in events if (words := _without_numbers(event))]
    return hashlib.sha256(repr(told).encode()).hexdigest()[:12]


def _without_numbers(event: FlightEvent) -> tuple[str, ...]:
    """The type of an event, and what it is about; empty if it makes no difference."""
    kind = type(event).__name__
    match event:
        case PhaseEntered():
            return kind, event.phase.value
        case SkillFailed():
            return kind, event.action
        case ConjunctViolated():
            return kind, event.conjunct
        case LineDropped() | LineTakenUp():
            return kind, event.line
        case _:
            return (kind,) if isinstance(event, BY_TYPE) else ()
