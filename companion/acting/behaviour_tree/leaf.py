"""The root of all leaves of the tree, and the reason why a tree has failed.

A leaf that fails says why in its `feedback_message`, as is usual with py_trees. Nothing else
carries a reason upwards: who wants to know why a node has failed asks `failure_of`.
"""

from __future__ import annotations

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.decorators import Inverter

from companion.acting.begun_steps import StepOwner
from companion.acting.behaviour_tree.deadline import Deadline
from companion.acting.flight import Flight
from companion.flight_events.tree import LeafType
from companion.vehicle.port import Failed, Outcome, Progress


class Leaf(Behaviour):
    """A behaviour without children.

    Attributes:
        does: what kind of leaf it is.
        nth: of the leaves of its action, from 0.

    Args:
        flight: what it acts on.
        name: what it is called on the monitor page.
    """

    does: LeafType

    def __init__(self, flight: Flight, name: str) -> None:
        super().__init__(name)
        self.nth = 0
        self._flight = flight

    def owner(self, asked: int = 0) -> StepOwner:
        """Whose step it is, for the action under way.

        Args:
            asked: which of the commands that a function has asked for; 0 for the leaf's own step.
        """
        task = self._flight.task
        action = task.running
        name, begun_as = (action.from_anywhere, action.name) if action is not None else ("", "")
        return StepOwner(name, task.positions, self.nth, asked, begun_as)

    def fail(self, reason: str) -> Status:
        """Returns FAILURE, with the reason for people."""
        self.feedback_message = reason
        return Status.FAILURE

    def status_of(self, outcome: Outcome) -> Status:
        """The status that an outcome is, with its reason."""
        if isinstance(outcome, Failed):
            return self.fail(outcome.reason)
        return Status.SUCCESS if outcome is Progress.DONE else Status.RUNNING


def leaves_of(node: Behaviour) -> list[Leaf]:
    """The leaves of a part of the tree, in order."""
    return [leaf for leaf in node.iterate() if isinstance(leaf, Leaf)]


def failure_of(node: Behaviour) -> str:
    """Returns why a node has failed: what the last of its leaves says that did; "" if none does."""
    if node.status is not Status.FAILURE:
        return ""
    if not node.children:
        return node.feedback_message
    if isinstance(node, Inverter):
        inverted = ", ".join(child.name for child in node.decorated.children)
        return f"{inverted} succeeded" if inverted else node.decorated.feedback_message
    failures = [failure_of(child) for child in reversed(node.children)]
    own = node.feedback_message if isinstance(node, Deadline) else ""
    return next(filter(None, failures), own)
