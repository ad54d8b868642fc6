"""What a part of the tree is there to do: one action, or one of several by where the vehicle is."""

from __future__ import annotations

from companion.acting.behaviour_tree.tries import Tries
from companion.mission.facts import Fact
from companion.planning.domain import Action


class Intention:
    """An action, or several that differ in where they begin: `move(*, A)`.

    Args:
        name: as people know it.
        actions: one of them is done; all have the same refinement.
        tries: the retries of a tree written by hand around it; None in a plan.

    Attributes:
        action: the one that is done, or was done last.
    """

    def __init__(self, name: str, actions: tuple[Action, ...], tries: Tries | None = None) -> None:
        self.name = name
        self.actions = actions
        self.action = actions[0]
        self.tries = tries or Tries()

    def choose(self, facts: frozenset[Fact]) -> None:
        """Takes the action that can begin, or the one that lacks least of it."""
        self.action = min(
            self.actions, key=lambda each: len(each.requires - facts) + len(each.forbids & facts)
        )
