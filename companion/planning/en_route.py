"""A vehicle between places: the facts about it, and the flight that was interrupted there."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from companion.mission.facts import AT, HERE, Fact, at
from companion.planning.domain import Action

AT_HERE = at(HERE)
"""The vehicle is at no place."""


def places(facts: frozenset[Fact]) -> frozenset[Fact]:
    """The facts that say where the vehicle is."""
    return frozenset(fact for fact in facts if fact.predicate == AT)


def at_no_place(facts: frozenset[Fact]) -> frozenset[Fact]:
    """The facts once the vehicle has left its place.

    >>> sorted(at_no_place(frozenset({at("A"), Fact("loaded")})))
    ['at(here)', 'loaded']
    """
    return facts - places(facts) | {AT_HERE}


@dataclass(frozen=True, slots=True)
class InterruptedFlight:
    """A flight that may be resumed.

    Attributes:
        flight: the action.
        left: the facts that said where the vehicle was before.
    """

    flight: Action
    left: frozenset[Fact]

    def facts_before(self, facts: frozenset[Fact]) -> frozenset[Fact]:
        """The present facts, as if the vehicle had not left."""
        return facts - {AT_HERE} | self.left

    def is_one_of(self, actions: Iterable[Action], facts: frozenset[Fact]) -> bool:
        """Whether it is one of these actions, and its precondition would hold where it began.

        Args:
            actions: the actions.
            facts: what holds now, with the beliefs.
        """
        is_own = any(action is self.flight for action in actions)
        return is_own and self.flight.is_applicable(self.facts_before(facts))
