"""A supposed state, other than the mission's first one, to plan from before a flight.

Facts and beliefs come in as people write them, spelled as in the mission. A name that the mission
does not know is a mistake, not a new fact.
"""

from __future__ import annotations

from collections.abc import Iterable

from companion.documents import did_you_mean
from companion.errors import MissionError
from companion.mission.facts import AT, Fact, at
from companion.mission.model import Mission
from companion.planning.instances import TaskModel


def supposed_facts(
    mission: Mission, model: TaskModel, place: str | None = None, facts: Iterable[str] = ()
) -> frozenset[Fact]:
    """The facts of a supposed state, without the beliefs.

    Args:
        mission: the mission; it says what holds at first.
        model: the actions and beliefs of the mission.
        place: the place of the vehicle; None for where the mission begins.
        facts: further facts that hold; with a `!` before it, a fact does not hold.

    Raises:
        MissionError: the mission lacks a fact or the place, or one of them is not a string.
    """
    state = mission.initially
    if place is not None:
        _check("place", _texts("place", [place]), mission.places)
        state = frozenset(f for f in state if f.predicate != AT) | {at(place)}
    literals = _texts("fact", facts)
    if not literals:
        return state
    fails = [literal.removeprefix("!").strip() for literal in literals if literal.startswith("!")]
    holds = [literal for literal in literals if not literal.startswith("!")]
    _check("fact", [*holds, *fails], _known_facts(mission, model))
    if moved := [name for name in holds if Fact.parse(name).predicate == AT]:
        what = f"{moved[0]} cannot be supposed among other facts: the vehicle is at one place"
        raise MissionError(what, hint="say the place: --at PLACE, or at= in Python")
    return state.union(map(Fact.parse, holds)).difference(fails)


def supposed_withdrawn(model: TaskModel, without: Iterable[str] = ()) -> frozenset[Fact]:
    """The beliefs that are withdrawn in a supposed state.

    Raises:
        MissionError: no skill assumes one of them, or one is not a string.
    """
    names = _texts("belief", without)
    _check("belief", names, model.beliefs)
    return frozenset(map(Fact.parse, names))


def _texts(kind: str, given: Iterable[str]) -> list[str]:
    """The given names, whether one or several."""
    listed = [given] if isinstance(given, str) or not isinstance(given, Iterable) else [*given]
    for each in listed:
        if not isinstance(each, str):
            raise MissionError(f"a {kind} is a text, and this is of type {type(each).__name__}")
    return sorted(listed)


def _known_facts(mission: Mission, model: TaskModel) -> frozenset[Fact]:
    """Every fact that the mission, its task or its actions mention, without the beliefs."""
    effects = (effect for action in model.actions for effect in action.conditional)
    known = mission.task_facts.union(
        mission.initially,
        (event.fact for event in mission.events.values()),
        *(a.requires | a.forbids | a.adds | a.deletes for a in model.actions),
        *(e.requires | e.forbids | e.adds | e.deletes for e in effects),
    )
    return known - model.beliefs


def _check(kind: str, names: Iterable[str], known: Iterable[str]) -> None:
    listed = sorted(known)
    for name in names:
        if name not in listed:
            listing = ", ".join(listed[:12]) + (", ..." if len(listed) > 12 else "")
            hint = f"{did_you_mean(name, listed)}\nknown are {listing}".strip()
            raise MissionError(f"the mission has no {kind} {name}", hint=hint)
