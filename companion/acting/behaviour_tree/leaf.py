"""The base class of all leaves of the tree, and the reason why a tree has failed.

A leaf that fails says why in its `feedback_message`, as is usual with py_trees. No other node
carries a reason upwards; `failure_of` finds the reason for any node.
"""

from __future__ import annotations

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.decorators import Inverter

from companion.acting.begun_steps import StepOwner
from companion.acting.behaviour_tree.deadline import Deadline
from companion.acting.flight import Flight
from companion.flight_events.tree import LeafType
from companion.outcomes import Failed, Outcome, Progress


class Leaf(Behaviour):
    """A behaviour without children.

    Attributes:
        does: what kind of leaf it is.
        nth: index of the leaf in its action, from 0.

    Args:
        flight: what it acts on.
        name: its name on the monitor page.
    """

    does: LeafType

    def __init__(self, flight: Flight, name: str) -> None:
        super().__init__(name)
        self.nth = 0
        self._flight = flight

    def owner(self, asked: int = 0) -> StepOwner:
        """The identity of a step of this leaf, in the present action.

        Args:
            asked: which of the commands that a function requested; 0 for the leaf's own step.
        """
        task = self._flight.task
        action = task.running
        name, begun_as = (action.from_anywhere, action.name) if action is not None else ("", "")
        return StepOwner(name, task.word.positions, self.nth, asked, begun_as)

    def fail(self, reason: str) -> Status:
        """Returns FAILURE, with the reason for people."""
        self.feedback_message = reason
        return Status.FAILURE

    def status_of(self, outcome: Outcome) -> Status:
        """The status for an outcome, with the outcome's reason."""
        if isinstance(outcome, Failed):
            return self.fail(outcome.reason)
        return Status.SUCCESS if outcome is Progress.DONE else Status.RUNNING


def leaves_of(node: Behaviour) -> list[Leaf]:
    """The leaves of a part of the tree, in order."""
    return [leaf for leaf in node.iterate() if isinstance(leaf, Leaf)]


def failure_of(node: Behaviour) -> str:
    """Returns why a node has failed: the message of the last failed leaf; "" if there is none."""
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
