"""A state other than the mission's first one, to plan from before a flight.

Facts and beliefs are named as the mission names them; a name that the mission does not know is a
mistake and not a new fact.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable

from companion.documents import did_you_mean
from companion.errors import MissionError
from companion.mission.model import Mission
from companion.planning.domain import Fact, TaskModel


def supposed_facts(
    mission: Mission,
    model: TaskModel,
    task_facts: frozenset[Fact],
    at: str | None = None,
    facts: Iterable[str] = (),
) -> frozenset[Fact]:
    """The facts of a supposed state, without the beliefs.

    Args:
        mission: says what holds at first.
        model: its actions and beliefs.
        task_facts: what the task mentions.
        at: the place where the vehicle is; None leaves it where the mission begins.
        facts: what else holds; with `!` before it, what does not hold.

    Raises:
        MissionError: the mission does not know a fact or the place.
    """
    state = mission.initially
    if at is not None:
        _check("place", [at], mission.places)
        state = frozenset(f for f in state if not f.startswith("at(")) | {f"at({at})"}
    literals = sorted(facts)
    fails = [literal.removeprefix("!").strip() for literal in literals if literal.startswith("!")]
    holds = [literal for literal in literals if not literal.startswith("!")]
    known = task_facts.union(mission.initially, mission.events, _facts_of(model))
    _check("fact", [*holds, *fails], known - model.beliefs)
    return (state | set(holds)) - set(fails)


def supposed_withdrawn(model: TaskModel, without: Iterable[str] = ()) -> frozenset[Fact]:
    """The beliefs that are withdrawn in a supposed state.

    Raises:
        MissionError: no skill assumes one of them.
    """
    withdrawn = frozenset(without)
    _check("belief", sorted(withdrawn), model.beliefs)
    return withdrawn


def _facts_of(model: TaskModel) -> frozenset[Fact]:
    """Every fact that the actions speak of."""
    effects = (effect for action in model.actions for effect in action.conditional)
    return frozenset().union(
        *(a.requires | a.forbids | a.adds | a.deletes for a in model.actions),
        *(e.requires | e.forbids | e.adds | e.deletes for e in effects),
    )


def _check(kind: str, names: Iterable[str], known: Collection[str]) -> None:
    for name in names:
        if name not in known:
            listing = ", ".join(sorted(known)[:12]) + (", ..." if len(known) > 12 else "")
            hint = f"{did_you_mean(name, sorted(known))}\nknown are {listing}".strip()
            raise MissionError(f"the mission has no {kind} {name}", hint=hint)
