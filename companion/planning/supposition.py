"""What if? A state other than the mission's first one, to plan from on the ground.

Facts and beliefs are named as the mission names them; a name that the mission does not know is a
mistake and not a new fact.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from companion.documents import did_you_mean
from companion.errors import MissionError
from companion.planning.domain import Fact
from companion.planning.planner import Planner


@dataclass(frozen=True, slots=True)
class Supposition:
    """A difference to the mission's first state.

    Attributes:
        at: the place where the vehicle is; None leaves it where the mission begins.
        holds: facts that hold.
        fails: facts that do not hold.
        without: beliefs that are withdrawn.
    """

    at: str | None = None
    holds: tuple[Fact, ...] = ()
    fails: tuple[Fact, ...] = ()
    without: tuple[Fact, ...] = ()

    def facts(self, planner: Planner) -> frozenset[Fact]:
        """The facts of the supposed state, without the beliefs.

        Raises:
            MissionError: the mission does not know a fact or the place.
        """
        facts = planner.mission.initially
        if self.at is not None:
            _check("place", [self.at], planner.mission.places)
            facts = frozenset(f for f in facts if not f.startswith("at(")) | {f"at({self.at})"}
        known = _facts_of(planner) - planner.model.beliefs
        _check("fact", [*self.holds, *self.fails], known)
        return (facts | set(self.holds)) - set(self.fails)

    def withdrawn(self, planner: Planner) -> frozenset[Fact]:
        """The beliefs that are withdrawn.

        Raises:
            MissionError: no skill assumes one of them.
        """
        _check("belief", self.without, planner.model.beliefs)
        return frozenset(self.without)


def _facts_of(planner: Planner) -> frozenset[Fact]:
    """Every fact that the mission can speak of."""
    actions = planner.model.actions
    return planner.task_facts.union(
        planner.mission.initially,
        planner.mission.events,
        *(a.requires | a.forbids | a.adds | a.deletes for a in actions),
        *(
            effect.requires | effect.forbids | effect.adds | effect.deletes
            for action in actions
            for effect in action.conditional
        ),
    )


def _check(kind: str, names: Collection[str], known: Collection[str]) -> None:
    for name in names:
        if name not in known:
            listing = ", ".join(sorted(known)[:12]) + (", ..." if len(known) > 12 else "")
            hint = f"{did_you_mean(name, sorted(known))}\nknown are {listing}".strip()
            raise MissionError(f"the mission has no {kind} {name}", hint=hint)
