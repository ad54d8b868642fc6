"""Checks on the templates that every effect keeps the vehicle at exactly one place.

An action template is written once for many places. If `!at(from)` is forgotten, plans contain
states in which the vehicle is at two places. So each effect is checked with its parameters unbound:
if the vehicle is at one place before, it has to be at one place afterwards.

Source: Helmert, Concise finite-domain representations for PDDL planning tasks, AIJ 2009, section 5,
which finds invariants of one fact on templates in the same way.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from itertools import combinations

from companion.documents import Document
from companion.errors import MissionError
from companion.mission.facts import AT
from companion.mission.skills import Literal, Skill


def check_one_place(
    skills: Mapping[str, Skill], places: Collection[str], document: Document
) -> None:
    """Refuses an effect after which the vehicle would be at two places, or at none.

    Raises:
        MissionError: at the first such effect, with what is missing in it.
    """
    for skill in skills.values():
        if not skill.is_planned:
            continue
        for change in _changes(skill, places):
            if fault := change.fault():
                what, remedy = fault
                where = document.where("skills", skill.name, "effect")
                raise MissionError(f"{skill.name} {what}", where, remedy)


@dataclass(frozen=True, slots=True)
class _Change:
    """What an effect changes about places; a place is given by a parameter or a constant.

    Attributes:
        before: where the vehicle is; all these names stand for the same place.
        left, reached: the places whose `at` the effect deletes and adds.
        places: all constants.
        distinct: groups of names whose members all differ.
    """

    before: frozenset[str]
    left: frozenset[str]
    reached: frozenset[str]
    places: frozenset[str]
    distinct: tuple[frozenset[str], ...]

    def fault(self) -> tuple[str, str] | None:
        """What is wrong, and the remedy; None if the vehicle is at one place afterwards."""
        reached = sorted(self.reached)
        if len(reached) > 1:
            one, other = reached[:2]
            return f"brings the vehicle to {one} and to {other}", "keep one of the two"
        if reached:
            return self._fault_of_arrival(reached[0])
        gone = sorted(
            place
            for place in self.left
            if not self.before or any(self._may_be_one(place, here) for here in self.before)
        )
        if gone:
            what = f"takes the vehicle away from {gone[0]}, and to no place"
            return what, f"add to its effect where it is then, or remove !at({gone[0]})"
        return None

    def _fault_of_arrival(self, goal: str) -> tuple[str, str] | None:
        if goal in self.before or self.left & self.before:
            return None
        if self.places <= self.left | {goal}:
            return None
        if not self.before:
            what = f"brings the vehicle to {goal}, whatever place it leaves"
            return what, "add at(from) to its precondition and !at(from) to its effect"
        here = min(self.before)
        what = f"brings the vehicle to {goal}, and leaves it at {here} too"
        return what, f"add !at({here}) to its effect"

    def _may_be_one(self, one: str, other: str) -> bool:
        """Whether two names may stand for the same place."""
        if one == other:
            return True
        are_places = one in self.places and other in self.places
        return not are_places and not any({one, other} <= group for group in self.distinct)

    @property
    def is_possible(self) -> bool:
        """Whether all names in `before` can stand for one place."""
        return all(self._may_be_one(a, b) for a, b in combinations(self.before, 2))


def _changes(skill: Skill, places: Collection[str]) -> Iterable[_Change]:
    """The effect without conditional parts, and with each one or two parts that change places."""
    about_places = [
        when
        for when in skill.conditional
        if any(literal.atom.predicate == AT for literal in when.effect)
    ]
    for count in range(3):
        for chosen in combinations(about_places, count):
            condition = [*skill.precondition, *(x for when in chosen for x in when.condition)]
            effect = [*skill.effect, *(x for when in chosen for x in when.effect)]
            change = _Change(
                _named(condition, True),
                _named(effect, False),
                _named(effect, True),
                frozenset(places),
                tuple(map(frozenset, skill.distinct)),
            )
            if change.is_possible and not change.before & _named(condition, False):
                yield change


def _named(literals: Iterable[Literal], is_positive: bool) -> frozenset[str]:
    """The places of the `at` facts among some literals."""
    return frozenset(
        literal.atom.arguments[0]
        for literal in literals
        if literal.atom.predicate == AT and literal.is_positive is is_positive
    )
