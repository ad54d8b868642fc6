"""Builds the behaviours of a tree that was written by hand in a mission (Section IV-A)."""

from __future__ import annotations

from collections.abc import Mapping

from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel as ParallelBehaviour
from py_trees.composites import Selector, Sequence
from py_trees.decorators import Inverter as InverterBehaviour
from py_trees.decorators import Repeat as RepeatBehaviour

from companion.acting.behaviour_tree.builder import FOR_EVER, action_tree
from companion.acting.behaviour_tree.deadline import Deadline
from companion.acting.behaviour_tree.intention import Intention
from companion.acting.behaviour_tree.leaf import Leaf
from companion.acting.behaviour_tree.leaves import Sleep
from companion.acting.behaviour_tree.tries import RetryByHand, Tries
from companion.acting.flight import Flight
from companion.flight_events.tree import LeafType
from companion.mission.facts import ANYWHERE, Fact
from companion.mission.tree_nodes import (
    Act,
    Check,
    Fallback,
    Inverter,
    Parallel,
    Repeat,
    Retry,
    Steps,
    Subtree,
    Timeout,
    Tree,
    WaitFor,
    Watch,
)
from companion.planning.domain import Action


class FactsHold(Leaf):
    """Checks that some facts hold, and others do not."""

    does = LeafType.FACTS

    def __init__(self, flight: Flight, check: Check) -> None:
        super().__init__(flight, check.text)
        self._check = check

    def update(self) -> Status:
        """SUCCESS if all facts are as required."""
        facts, check = self._flight.task.all_facts, self._check
        if check.requires <= facts and not check.forbids & facts:
            return Status.SUCCESS
        return self.fail(f"not {check.text}")


class WatchedFacts(FactsHold):
    """The facts of a watch; what was begun on the ground is finished before they count."""

    def update(self) -> Status:
        """SUCCESS while all facts are as required."""
        is_landed = self._flight.progress.is_landed_by_plan
        return Status.SUCCESS if is_landed else super().update()


class SubtreeSequence(Sequence):
    """The steps of a subtree."""


Actions = Mapping[str, tuple[Action, ...]]
"""By name in the tree: the action, or one action for each place where it may begin."""


def build_by_hand(
    flight: Flight, node: Tree, actions: Actions, tries: Tries | None = None
) -> Behaviour:
    """The behaviours of a node.

    Args:
        flight: what the leaves act on.
        node: the root, or a part of it.
        actions: the actions of the tree.
        tries: the retries around the node; None if there are none.
    """

    def below(each: Tree) -> Behaviour:
        return build_by_hand(flight, each, actions, tries)

    match node:
        case Act(name):
            return _action(flight, name, actions[name], tries)
        case Check():
            return FactsHold(flight, node)
        case WaitFor(duration_s):
            return Sleep(flight, f"wait {duration_s:g} s", duration_s)
        case Steps(nodes):
            return Sequence("steps", memory=True, children=[*map(below, nodes)])
        case Subtree(name, Steps(nodes)):
            return SubtreeSequence(name, memory=True, children=[*map(below, nodes)])
        case Fallback(nodes):
            return Selector("fallback", memory=True, children=[*map(below, nodes)])
        case Parallel(nodes):
            all_of_them = ParallelPolicy.SuccessOnAll(synchronise=True)
            return ParallelBehaviour("parallel", all_of_them, [*map(below, nodes)])
        case Inverter(steps):
            return InverterBehaviour("inverter", below(steps))
        case Repeat(steps, times):
            return RepeatBehaviour("repeat", below(steps), FOR_EVER if times is None else times)
        case Retry(steps, times):
            own = Tries(around=tries)
            own.retry = RetryByHand(flight, build_by_hand(flight, steps, actions, own), times)
            return own.retry
        case Timeout(steps, duration_s):
            return Deadline(flight, below(steps), duration_s)
        case Watch(condition, steps):
            watched = [WatchedFacts(flight, condition), below(steps)]
            return Sequence(f"watch {condition.text}", memory=False, children=watched)


def _action(
    flight: Flight, name: str, actions: tuple[Action, ...], tries: Tries | None
) -> Behaviour:
    """An action; one that may begin anywhere does nothing if its effect already holds."""
    tree = action_tree(flight, Intention(name, actions, tries), None, is_by_hand=True)
    done = frozenset[Fact].intersection(*(action.adds for action in actions))
    if ANYWHERE not in name or not done or any(action.conditional for action in actions):
        return tree
    there = Check(" & ".join(sorted(done)), done, frozenset())
    return Selector(name, memory=True, children=[FactsHold(flight, there), tree])
