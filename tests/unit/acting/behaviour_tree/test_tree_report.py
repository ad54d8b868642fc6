"""A tree's history, read back from what was told: at each tick every node as py_trees has it."""

from __future__ import annotations

from fakes import failed
from py_trees.behaviour import Behaviour
from rig import Rig
from synthetic import command, mission, move

from companion.acting.behaviour_tree.builder import build
from companion.acting.behaviour_tree.tree_report import TreeReport
from companion.acting.replanning.assumptions import Assumptions
from companion.acting.report import Report


class Reader:
    """Reads `tree` and `status` back."""

    def __init__(self) -> None:
        self.nodes: list[dict[str, object]] = []
        self.statuses: list[str] = []

    def read(self, reports: list[Report]) -> int:
        """How many of the reports were for it."""
        told = [report for report in reports if report.kind in ("tree", "status")]
        for report in told:
            if report.kind == "tree":
                self.nodes = report.data["nodes"]  # type: ignore[assignment]
                self.statuses = ["INVALID"] * len(self.nodes)
            else:
                for number, status, _ in report.data["changed"]:  # type: ignore[attr-defined]
                    assert self.statuses[number] != status, "no change"
                    self.statuses[number] = status
        return len(told)


def nodes_of(root: Behaviour) -> list[Behaviour]:
    """Depth first, children in their order."""
    return [root, *(node for child in root.children for node in nodes_of(child))]


def test_what_was_told_is_the_tree_at_every_tick() -> None:
    """A lap and a bit: nodes run, succeed, and are reset when the loop begins again."""
    rig, reader = Rig(mission("G F at(A) & G F at(H)")), Reader()
    lasso = rig.planner.solve(*rig.task.problem()).lasso
    root = build(rig.flight, lasso, Assumptions(rig.planner, rig.flight))
    report = TreeReport(rig.flight, root)
    seen, quiet = set(), 0
    for _ in range(400):
        rig.pass_time()
        root.tick_once()
        report.tell()
        quiet += reader.read(rig.flight.reports) == 0
        rig.flight.reports.clear()
        assert reader.statuses == [node.status.value for node in nodes_of(root)]
        seen |= set(reader.statuses)
    assert rig.flight.progress.laps >= 1
    assert seen == {"RUNNING", "SUCCESS", "INVALID"}
    assert quiet > 350, "a tick that changes nothing tells nothing"


def test_nodes_say_what_they_are_and_actions_what_they_are_about() -> None:
    rig, reader = Rig(mission("F at(A)")), Reader()
    rig.executive.plan()
    reader.read(rig.flight.reports)
    shape = [(node["depth"], node["type"], node["name"]) for node in reader.nodes[:5]]
    assert shape == [
        (0, "sequence", "root"),
        (1, "leaf", "as predicted?"),
        (1, "sequence", "plan"),
        (2, "action", "move(H, A)"),
        (3, "sequence", "triple"),
    ]
    first, *_, last = [node for node in reader.nodes if node["type"] == "action"]
    assert first["destination"] == "A" and first["assumes"] == ["trans_ok(H, A)"]
    assert last["name"] == "wait" and last["destination"] is None


def test_an_executive_that_is_stopped_has_a_tree_that_does_nothing() -> None:
    rig, reader = Rig(mission("F at(A)")), Reader()
    rig.executive.plan()
    rig.pass_time()
    rig.executive.tick()
    reader.read(rig.flight.reports)
    assert "RUNNING" in reader.statuses
    rig.executive.stop()
    reader.read(rig.flight.reports)
    assert set(reader.statuses) == {"INVALID"}


def test_a_leaf_that_fails_says_why() -> None:
    rig = Rig(mission("F done", skills=[move(), command("do", "at(H)", "done")]))
    rig.vehicle.answers = [(0.0, failed("denied"))]
    rig.executive.plan()
    for _ in range(3):
        rig.pass_time()
        rig.executive.tick()
    told = [r.data["changed"] for r in rig.flight.reports if r.kind == "status"]
    words = [entry for changed in told for entry in changed]  # type: ignore[attr-defined]
    assert [status for _, status, said in words if "denied" in said] == ["FAILURE"]
