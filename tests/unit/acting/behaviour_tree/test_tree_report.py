"""A tree's history, read back from what was told: at each tick every node as py_trees has it."""

from __future__ import annotations

from py_trees.behaviour import Behaviour
from rig import Rig
from synthetic import command, mission, move

from companion.acting.behaviour_tree.builder import build
from companion.acting.behaviour_tree.tree_report import TreeReport
from companion.acting.replanning.assumptions import Assumptions
from companion.flight_events.event import Stamped
from companion.flight_events.tree import (
    ActionTreeNode,
    LeafTreeNode,
    LeafType,
    NodesChanged,
    NodeStatus,
    NodeType,
    TreeBuilt,
    TreeNode,
    TreeStopped,
)
from companion.outcomes import Failed


class Reader:
    """Reads back what is told of trees and their nodes."""

    def __init__(self) -> None:
        self.nodes: tuple[TreeNode, ...] = ()
        self.statuses: list[NodeStatus] = []

    def read(self, reports: list[Stamped]) -> int:
        """How many of the events were for it."""
        count = 0
        for stamped in reports:
            match stamped.event:
                case TreeBuilt(nodes=nodes):
                    self.nodes = nodes
                    self.statuses = [NodeStatus.INVALID] * len(nodes)
                    count += 1
                case NodesChanged(changed=changed) | TreeStopped(changed=changed):
                    for number, status, _ in changed:
                        assert self.statuses[number] != status, "no change"
                        self.statuses[number] = status
                    count += 1
        return count


def nodes_of(root: Behaviour) -> list[Behaviour]:
    """Depth first, children in their order."""
    return [root, *(node for child in root.children for node in nodes_of(child))]


def test_what_was_told_is_the_tree_at_every_tick() -> None:
    """A lap and a bit: nodes run, succeed, and are reset when the loop begins again."""
    rig, reader = Rig(mission("G F at(A) & G F at(H)")), Reader()
    lasso = rig.planner.solver.solve(*rig.task.problem()).lasso
    root = build(rig.flight, lasso, Assumptions(rig.planner, rig.flight))
    report = TreeReport(rig.flight, root)
    seen, quiet = set[NodeStatus](), 0
    for _ in range(400):
        rig.pass_time()
        root.tick_once()
        report.tell()
        quiet += reader.read(rig.flight.collect_reports()) == 0
        assert [s.value for s in reader.statuses] == [n.status.value for n in nodes_of(root)]
        seen |= set(reader.statuses)
    assert rig.flight.progress.laps >= 1
    assert seen == {NodeStatus.RUNNING, NodeStatus.SUCCESS, NodeStatus.INVALID}
    assert quiet > 350, "a tick that changes nothing tells nothing"


def test_nodes_say_what_they_are_and_actions_what_they_are_about() -> None:
    rig, reader = Rig(mission("F at(A)")), Reader()
    rig.executive.plan()
    reader.read(rig.flight.reports)
    assert reader.nodes[:5] == (
        TreeNode(0, NodeType.REACTIVE_SEQUENCE, "root"),
        LeafTreeNode(1, NodeType.LEAF, "as predicted?", LeafType.ASSUMPTIONS),
        TreeNode(1, NodeType.SEQUENCE, "plan"),
        ActionTreeNode(2, NodeType.ACTION, "move(H, A)", "A", ("trans_ok(H, A)",)),
        TreeNode(3, NodeType.SEQUENCE, "triple"),
    )
    *_, last = [node for node in reader.nodes if isinstance(node, ActionTreeNode)]
    assert last.name == "wait" and last.destination is None


def test_an_executive_that_is_stopped_has_a_tree_that_does_nothing() -> None:
    rig, reader = Rig(mission("F at(A)")), Reader()
    rig.executive.plan()
    rig.pass_time()
    rig.executive.tick()
    reader.read(rig.flight.reports)
    assert NodeStatus.RUNNING in reader.statuses
    rig.executive.stop()
    assert isinstance(rig.flight.reports[-1].event, TreeStopped)
    reader.read(rig.flight.reports)
    assert set(reader.statuses) == {NodeStatus.INVALID}


def test_a_leaf_that_fails_says_why() -> None:
    rig = Rig(mission("F done", skills=[move(), command("do", "at(H)", "done")]))
    rig.vehicle.payloads.answers = [(0.0, Failed("denied"))]
    rig.executive.plan()
    for _ in range(3):
        rig.pass_time()
        rig.executive.tick()
    told = [s.event.changed for s in rig.flight.reports if isinstance(s.event, NodesChanged)]
    changes = [change for changed in told for change in changed]
    denied = [change.status for change in changes if "denied" in change.feedback]
    assert denied == [NodeStatus.FAILURE]
