"""What does the tree look like, and what is each of its nodes doing? Told when it changes.

A tree is told node by node, in depth-first order, the first time; later ticks tell only the nodes
whose status has changed since, by their number in that order. So a tree's whole history can be
read back, and a tick that changes nothing costs one look at each node.
"""

from __future__ import annotations

from collections.abc import Iterator

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Selector, Sequence
from py_trees.decorators import Decorator, Repeat

from companion.acting.behaviour_tree.builder import ActionNode
from companion.acting.flight import Flight


class TreeReport:
    """Tells of one tree.

    Args:
        flight: where reports go.
        root: the tree; it keeps its nodes.
    """

    def __init__(self, flight: Flight, root: Behaviour) -> None:
        self._flight = flight
        self._root = root
        self._depths = list(_preorder(root, 0))
        self._nodes = [node for node, _ in self._depths]
        self._statuses: list[Status] = []

    def tell(self) -> None:
        """Tells the tree, once, and the nodes whose status has changed since the last call."""
        if not self._statuses:
            self._statuses = [Status.INVALID] * len(self._nodes)
            nodes = [_as_json(node, depth) for node, depth in self._depths]
            self._flight.report("tree", f"a tree of {len(nodes)} nodes", nodes=nodes)
        statuses = [node.status for node in self._nodes]
        if statuses == self._statuses:
            return
        changed = [
            [number, status.value, _feedback(node)]
            for number, (node, status) in enumerate(zip(self._nodes, statuses, strict=True))
            if status is not self._statuses[number]
        ]
        self._statuses = statuses
        tip = self._root.tip()
        text = f"{tip.name}: {tip.status.value}" if tip else "nothing runs"
        self._flight.report("status", text, changed=changed)


def _feedback(node: Behaviour) -> str:
    """Why a leaf has failed; "" for everything else."""
    is_failed_leaf = not node.children and node.status is Status.FAILURE
    return node.feedback_message if is_failed_leaf else ""


def _preorder(node: Behaviour, depth: int) -> Iterator[tuple[Behaviour, int]]:
    """A node and all below it, with their depths."""
    yield node, depth
    for child in node.children:
        yield from _preorder(child, depth + 1)


def _as_json(node: Behaviour, depth: int) -> dict[str, object]:
    told: dict[str, object] = {"depth": depth, "type": _type(node), "name": node.name}
    if isinstance(node, ActionNode):
        told["destination"] = node.action.destination
        told["assumes"] = sorted(node.action.assumes)
    return told


def _type(node: Behaviour) -> str:
    match node:
        case ActionNode():
            return "action"
        case Sequence():
            return "sequence"
        case Selector():
            return "selector"
        case Repeat():
            return "repeat"
        case Decorator():
            return "decorator"
    return "leaf"
