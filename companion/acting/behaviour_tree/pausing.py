"""A pause in a tree that is not replaced: what was under way begins anew when it is over.

Leaves alone are stopped. Sequences, retries and repeats stay where they are, and the actions under
way stay so: a pause is no failed try. A flight goes on from where the vehicle is, a command where
it was, a wait begins again.
"""

from __future__ import annotations

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from companion.acting.behaviour_tree.deadline import Deadline


def pause(root: Behaviour) -> None:
    """Stops what is under way."""
    for node in root.iterate():
        if not node.children and node.status is Status.RUNNING:
            node.stop(Status.INVALID)


def resume(root: Behaviour, paused_s: float) -> None:
    """The next tick goes on; time limits do not count the pause."""
    for node in root.iterate():
        if isinstance(node, Deadline) and node.status is Status.RUNNING:
            node.postpone(paused_s)
