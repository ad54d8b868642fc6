"""Pauses a tree that is not replaced; afterwards what was under way starts again.

Only leaves are stopped. Sequences, retries, repeats and the present actions stay where they are: a
pause is no failed try. Afterwards a flight continues from where the vehicle is, a command from
where it was, and a wait starts again.
"""

from __future__ import annotations

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from companion.acting.behaviour_tree.deadline import Deadline


def pause(root: Behaviour) -> None:
    """Stops the leaves that are running."""
    for node in root.iterate():
        if not node.children and node.status is Status.RUNNING:
            node.stop(Status.INVALID)


def resume(root: Behaviour, paused_s: float) -> None:
    """Lets the next tick continue; time limits do not count the pause."""
    for node in root.iterate():
        if isinstance(node, Deadline) and node.status is Status.RUNNING:
            node.postpone(paused_s)
