"""The purpose of a part of the tree: one action, or one of several by where they begin."""

from __future__ import annotations

from companion.acting.behaviour_tree.tries import Tries
from companion.mission.facts import Fact
from companion.planning.domain import Action


class Intention:
    """An action, or several that differ only in where they begin: `move(*, A)`.

    Args:
        name: as people know it.
        actions: one of them is done; all have the same refinement.
        tries: the retries around it in a tree written by hand; None in a plan.

    Attributes:
        action: the action that is done, or was done last.
    """

    def __init__(self, name: str, actions: tuple[Action, ...], tries: Tries | None = None) -> None:
        self.name = name
        self.actions = actions
        self.action = actions[0]
        self.tries = tries or Tries()

    def choose(self, facts: frozenset[Fact]) -> None:
        """Chooses the action that can begin, or the one that misses the fewest facts."""
        self.action = min(
            self.actions, key=lambda each: len(each.requires - facts) + len(each.forbids & facts)
        )
