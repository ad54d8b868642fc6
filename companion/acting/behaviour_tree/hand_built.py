"""The tree of a mission that was written by hand (Section IV-A): its nodes as behaviours."""

from __future__ import annotations

from collections.abc import Mapping

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Selector, Sequence
from py_trees.decorators import Repeat as RepeatDecorator
from py_trees.decorators import Retry as RetryDecorator

from companion.acting.behaviour_tree.builder import FOR_EVER, action_tree
from companion.acting.behaviour_tree.leaf import Leaf
from companion.acting.flight import Flight
from companion.mission.tree_nodes import (
    Act,
    Check,
    Fallback,
    Repeat,
    Retry,
    Steps,
    Tree,
    Watch,
)
from companion.planning.domain import Action


class FactsHold(Leaf):
    """Some facts hold, and others do not."""

    def __init__(self, flight: Flight, check: Check) -> None:
        super().__init__(flight, check.text)
        self._check = check

    def update(self) -> Status:
        """SUCCESS if all is as it was written."""
        facts, check = self._flight.task.all_facts, self._check
        if check.requires <= facts and not check.forbids & facts:
            return Status.SUCCESS
        return self.fail(f"not {check.text}")


def build_by_hand(flight: Flight, node: Tree, actions: Mapping[str, Action]) -> Behaviour:
    """The behaviours of a node.

    Args:
        flight: what the leaves act on.
        node: the root, or a part of it.
        actions: those of the tree, by name.
    """

    def below(nodes: tuple[Tree, ...]) -> list[Behaviour]:
        return [build_by_hand(flight, each, actions) for each in nodes]

    match node:
        case Act(name):
            return action_tree(flight, actions[name], None)
        case Check():
            return FactsHold(flight, node)
        case Steps(nodes):
            steps = Sequence("steps", memory=True)
            steps.add_children(below(nodes))
            return steps
        case Fallback(nodes):
            fallback = Selector("fallback", memory=True)
            fallback.add_children(below(nodes))
            return fallback
        case Repeat(steps, times):
            child = build_by_hand(flight, steps, actions)
            return RepeatDecorator("repeat", child, FOR_EVER if times is None else times)
        case Retry(steps, times):
            return RetryDecorator("retry", build_by_hand(flight, steps, actions), times)
        case Watch(condition, steps):
            watch = Sequence(f"watch {condition.text}", memory=False)
            watch.add_children(
                [FactsHold(flight, condition), build_by_hand(flight, steps, actions)]
            )
            return watch
