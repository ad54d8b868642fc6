"""Reports what the tree looks like, and what each of its nodes does, when it changes.

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
from companion.flight_events.tree import (
    ActionTreeNode,
    NodeChange,
    NodesChanged,
    NodeStatus,
    NodeType,
    TreeBuilt,
    TreeNode,
    TreeStopped,
)


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
            nodes = tuple(_described(node, depth) for node, depth in self._depths)
            self._flight.report(TreeBuilt(nodes))
        statuses = [node.status for node in self._nodes]
        if statuses == self._statuses:
            return
        changed = tuple(
            NodeChange(number, NodeStatus(status.value), _feedback(node))
            for number, (node, status) in enumerate(zip(self._nodes, statuses, strict=True))
            if status is not self._statuses[number]
        )
        self._statuses = statuses
        tip = self._root.tip()
        self._flight.report(
            NodesChanged(tip.name, NodeStatus(tip.status.value), changed)
            if tip
            else TreeStopped(changed)
        )


def _feedback(node: Behaviour) -> str:
    """Why a leaf has failed; "" for everything else."""
    is_failed_leaf = not node.children and node.status is Status.FAILURE
    return node.feedback_message if is_failed_leaf else ""


def _preorder(node: Behaviour, depth: int) -> Iterator[tuple[Behaviour, int]]:
    """A node and all below it, with their depths."""
    yield node, depth
    for child in node.children:
        yield from _preorder(child, depth + 1)


def _described(node: Behaviour, depth: int) -> TreeNode | ActionTreeNode:
    match node:
        case ActionNode(action=action):
            assumes = tuple(sorted(action.assumes))
            return ActionTreeNode(depth, NodeType.ACTION, node.name, action.destination, assumes)
        case Sequence():
            return TreeNode(depth, NodeType.SEQUENCE, node.name)
        case Selector():
            return TreeNode(depth, NodeType.SELECTOR, node.name)
        case Repeat():
            return TreeNode(depth, NodeType.REPEAT, node.name)
        case Decorator():
            return TreeNode(depth, NodeType.DECORATOR, node.name)
    return TreeNode(depth, NodeType.LEAF, node.name)
