"""Behaviour trees in the XML format of BehaviorTree.CPP, version 4.

Sequences, fallbacks and decorators are those of the library. Leaves are our own nodes, declared in
TreeNodesModel, so that editors such as Groot2 can show them. Each subtree is a tree of its own.

Source: https://www.behaviortree.dev/docs/learn-the-basics/xml_format, and the rules that the
library checks (`VerifyXML` in its xml_parsing.cpp, and its btcpp4_schematron.sch).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from companion.flight_events.tree import (
    CountedTreeNode,
    LeafTreeNode,
    LeafType,
    NodeType,
    PlanNode,
    TimedTreeNode,
)

CONTROLS = {
    NodeType.SEQUENCE: "Sequence",
    NodeType.REACTIVE_SEQUENCE: "ReactiveSequence",
    NodeType.SELECTOR: "Fallback",
    NodeType.ACTION: "Fallback",
    NodeType.PARALLEL: "Parallel",
    NodeType.REPEAT: "Repeat",
    NodeType.RETRY: "RetryUntilSuccessful",
    NodeType.INVERTER: "Inverter",
    NodeType.TIMEOUT: "Timeout",
}
"""Nodes of the library."""
LEAVES = {
    LeafType.ASSUMPTIONS: ("Condition", "AssumptionsHold"),
    LeafType.PRECONDITION: ("Action", "BeginAction"),
    LeafType.EFFECTS: ("Action", "ApplyEffects"),
    LeafType.WITHDRAW: ("Action", "WithdrawBeliefs"),
    LeafType.UPDATE_PARAM: ("Action", "UpdateParam"),
    LeafType.MOVE_CMD: ("Action", "MoveCommand"),
    LeafType.LOOK_AT: ("Action", "LookAt"),
    LeafType.COMMAND: ("Action", "SendCommand"),
    LeafType.PHOTO: ("Action", "TakePhoto"),
    LeafType.GIMBAL: ("Action", "PointGimbal"),
    LeafType.CONFIRM: ("Action", "Confirm"),
    LeafType.PYTHON: ("Action", "CallFunction"),
    LeafType.WAIT: ("Action", "Wait"),
    LeafType.LAND: ("Action", "Land"),
    LeafType.LAND_ON: ("Action", "LandOnMarker"),
    LeafType.TAKE_OFF: ("Action", "TakeOff"),
    LeafType.CHARGE: ("Action", "ChargeBattery"),
    LeafType.BEGIN_AGAIN: ("Action", "BeginAgain"),
    LeafType.FACTS: ("Condition", "FactsHold"),
    LeafType.STILL_THERE: ("Condition", "StillThere"),
}
"""Our own nodes: the library's type of each, and its ID."""
MAIN = "MainTree"
FOR_EVER = -1
"""Number of cycles of a repeat that never ends."""


def to_xml(nodes: Sequence[PlanNode]) -> str:
    """The XML document of a tree.

    Args:
        nodes: depth first, each with its depth.
    """
    return _Document().written(nodes)


@dataclass
class _Document:
    """One document.

    Attributes:
        trees: the subtrees written so far, by their names in the mission.
        leaves: kinds of leaves that occur.
    """

    trees: dict[str, Element] = field(default_factory=dict)
    leaves: set[LeafType] = field(default_factory=set)

    def written(self, nodes: Sequence[PlanNode]) -> str:
        main = Element("BehaviorTree", ID=MAIN)
        self._write(nodes, main)
        attributes = {"BTCPP_format": "4", "main_tree_to_execute": MAIN}
        root = Element("root", attributes)
        root.extend([main, *self.trees.values()])
        model = SubElement(root, "TreeNodesModel")
        for leaf in LeafType:
            if leaf in self.leaves:
                kind, name = LEAVES[leaf]
                SubElement(model, kind, ID=name)
        ElementTree.indent(root)
        return '<?xml version="1.0" encoding="UTF-8"?>\n' + _text(root)

    def _write(self, nodes: Sequence[PlanNode], parent: Element) -> None:
        """Writes the first node, with all nodes below it, as a child of `parent`."""
        node, below = nodes[0], nodes[1:]
        if node.type is NodeType.SUBTREE:
            self._write_subtree(node.name, below)
            SubElement(parent, "SubTree", ID=_id(node.name), name=node.name)
            return
        element = SubElement(parent, *self._described(node))
        for child in _children(below):
            self._write(child, element)

    def _write_subtree(self, name: str, below: Sequence[PlanNode]) -> None:
        """Writes the tree of a subtree, its steps as a sequence, unless it is there already."""
        if name not in self.trees:
            tree = self.trees[name] = Element("BehaviorTree", ID=_id(name))
            steps = SubElement(tree, "Sequence", name=name)
            for child in _children(below):
                self._write(child, steps)

    def _described(self, node: PlanNode) -> tuple[str, dict[str, str]]:
        """The XML tag and the attributes of a node."""
        named = {"name": node.name}
        match node:
            case LeafTreeNode(does=leaf):
                self.leaves.add(leaf)
                kind, name = LEAVES[leaf]
                return kind, {"ID": name} | named
            case TimedTreeNode(duration_s=duration_s):
                return CONTROLS[node.type], named | {"msec": str(round(1000 * duration_s))}
            case CountedTreeNode(times=times, type=NodeType.RETRY):
                return CONTROLS[node.type], named | {"num_attempts": str(times)}
            case CountedTreeNode(times=times):
                return CONTROLS[node.type], named | {"num_cycles": str(times or FOR_EVER)}
        if node.type is NodeType.PARALLEL:
            return CONTROLS[node.type], named | {"success_count": "-1", "failure_count": "1"}
        return CONTROLS[node.type], named


def _id(subtree: str) -> str:
    """The ID of a subtree; its prefix distinguishes it from the nodes."""
    return f"subtree_{subtree}"


def _children(below: Sequence[PlanNode]) -> list[Sequence[PlanNode]]:
    """The children of a node, each with all nodes below it."""
    if not below:
        return []
    depth = below[0].depth
    starts = [i for i, node in enumerate(below) if node.depth == depth]
    return [below[a:b] for a, b in zip(starts, [*starts[1:], len(below)], strict=True)]


def _text(root: Element) -> str:
    return ElementTree.tostring(root, encoding="unicode") + "\n"
