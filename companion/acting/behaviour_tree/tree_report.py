"""Reports the nodes of the tree once, and then each change of a node's status.

The first time, all nodes are reported in depth-first order. Later ticks report only the nodes whose
status has changed, by their number in that order. So a tree's whole history can be read back, and a
tick without changes costs one comparison for each node.
"""

from __future__ import annotations

from collections.abc import Iterator

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Parallel, Selector, Sequence
from py_trees.decorators import Inverter, Repeat, Retry

from companion.acting.behaviour_tree.builder import FOR_EVER, ActionNode
from companion.acting.behaviour_tree.deadline import Deadline
from companion.acting.behaviour_tree.hand_built import SubtreeSequence
from companion.acting.behaviour_tree.leaf import Leaf
from companion.acting.flight import Flight
from companion.flight_events.tree import (
    ActionTreeNode,
    CountedTreeNode,
    LeafTreeNode,
    NodeChange,
    NodesChanged,
    NodeStatus,
    NodeType,
    PlanNode,
    TimedTreeNode,
    TreeBuilt,
    TreeNode,
    TreeStopped,
)
from companion.mission.facts import Fact


class TreeReport:
    """Reports on one tree.

    Args:
        flight: receives the reports.
        root: the tree, whose nodes stay the same.
    """

    def __init__(self, flight: Flight, root: Behaviour) -> None:
        self._flight = flight
        self._root = root
        self._nodes = [node for node, _ in _preorder(root, 0)]
        self._statuses: list[Status] = []

    def tell(self) -> None:
        """Reports the tree once, and the nodes whose status has changed since the last call."""
        if not self._statuses:
            self._statuses = [Status.INVALID] * len(self._nodes)
            self._flight.report(TreeBuilt(described(self._root)))
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


def described(root: Behaviour) -> tuple[PlanNode, ...]:
    """The nodes of a tree, depth first."""
    return tuple(_described(node, depth) for node, depth in _preorder(root, 0))


def _feedback(node: Behaviour) -> str:
    """Why a leaf has failed; "" for everything else."""
    is_failed_leaf = not node.children and node.status is Status.FAILURE
    return node.feedback_message if is_failed_leaf else ""


def _preorder(node: Behaviour, depth: int) -> Iterator[tuple[Behaviour, int]]:
    """A node and all below it, with their depths."""
    yield node, depth
    for child in node.children:
        yield from _preorder(child, depth + 1)


def _described(node: Behaviour, depth: int) -> PlanNode:
    match node:
        case ActionNode(intention=intention):
            action, of_all = intention.action, (each.assumes for each in intention.actions)
            assumes = tuple(sorted(frozenset[Fact]().union(*of_all)))
            return ActionTreeNode(depth, NodeType.ACTION, node.name, action.destination, assumes)
        case SubtreeSequence():
            return TreeNode(depth, NodeType.SUBTREE, node.name)
        case Sequence(memory=False):
            return TreeNode(depth, NodeType.REACTIVE_SEQUENCE, node.name)
        case Sequence():
            return TreeNode(depth, NodeType.SEQUENCE, node.name)
        case Selector():
            return TreeNode(depth, NodeType.SELECTOR, node.name)
        case Parallel():
            return TreeNode(depth, NodeType.PARALLEL, node.name)
        case Repeat(num_success=times):
            limit = None if times == FOR_EVER else times
            return CountedTreeNode(depth, NodeType.REPEAT, node.name, limit)
        case Retry(num_failures=times):
            return CountedTreeNode(depth, NodeType.RETRY, node.name, times)
        case Deadline(timeout_s=duration_s):
            return TimedTreeNode(depth, NodeType.TIMEOUT, node.name, duration_s)
        case Inverter():
            return TreeNode(depth, NodeType.INVERTER, node.name)
        case Leaf():
            return LeafTreeNode(depth, NodeType.LEAF, node.name, node.does)
    raise TypeError(f"a {type(node).__name__} in a tree")
