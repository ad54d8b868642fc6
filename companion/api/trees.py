"""Behaviour trees of plans: of a mission's first plan, or of the last one that a run has ticked."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from companion.acting.preparation import prepare
from companion.api.results import FlightResult, Recording
from companion.api.tree_xml import to_xml
from companion.errors import MissionError, check_kind
from companion.flight_events.tree import NodeType, PlanNode, TreeBuilt
from companion.mission.model import Mission
from companion.mission_run import PreparedRun, Run
from companion.record.events import read_events, record_of
from companion.vehicle.telemetry import Telemetry
from companion.vehicle.wire import Wire

_SHAPES = {NodeType.ACTION: "box", NodeType.LEAF: "box"}
"""In the DOT language; all others are ellipses."""


@dataclass(frozen=True, slots=True)
class BehaviourTree:
    """A behaviour tree as it is ticked.

    Attributes:
        nodes: depth first, each with its depth; the root, which comes first, has depth 0.
    """

    nodes: tuple[PlanNode, ...]

    def to_text(self) -> str:
        """A line for each node, indented by its depth: what it is, and its name."""
        return "".join(f"{'  ' * node.depth}{_in_words(node)}\n" for node in self.nodes)

    def to_dot(self) -> str:
        """The tree as a directed graph in the DOT language of Graphviz."""
        lines = ["digraph tree {", "  ordering=out"]
        path: list[int] = []  # the nodes from the root to the present one
        for number, node in enumerate(self.nodes):
            label = _in_words(node).replace("\\", "\\\\").replace('"', '\\"')
            shape = _SHAPES.get(node.type, "ellipse")
            lines.append(f'  n{number} [label="{label}", shape={shape}]')
            path[node.depth :] = [number]
            if node.depth:
                lines.append(f"  n{path[-2]} -> n{number}")
        return "\n".join([*lines, "}", ""])

    def to_xml(self) -> str:
        """The tree in the XML format of BehaviorTree.CPP, version 4, as Groot2 shows it."""
        return to_xml(self.nodes)


def behaviour_tree(of: Mission | FlightResult | Path | str) -> BehaviourTree:
    """The behaviour tree of a plan.

    >>> from companion import behaviour_tree, load_mission
    >>> tree = behaviour_tree(load_mission("missions/surveillance.yaml"))
    >>> print(*tree.to_text().splitlines()[:4], sep="\\n")
    reactive_sequence root
      as predicted?
      sequence plan
        action move(Home, A)

    Args:
        of: a mission, for its first plan or the tree that it brings; or a run folder, or what
            `simulate` or `run` returned, for the tree that was ticked last.

    Raises:
        NoPlan: the mission has none; its `explanation` says why.
        SearchLimit: the search for a plan was given up.
        MissionError: it is no run folder, a line of it is not as documented, or nothing was flown.
        CompanionError: it is nothing of these kinds.
    """
    if isinstance(of, Mission):
        return BehaviourTree(_planned(of).nodes)
    check_kind(of, (FlightResult, Path, str), "a mission, a flight, or a run folder")
    record = record_of(of.events) if isinstance(of, FlightResult) else read_events(Path(of))
    if record.tree is None:
        raise MissionError("no behaviour tree was ticked in this run")
    return BehaviourTree(record.tree.nodes)


def _planned(mission: Mission) -> TreeBuilt:
    """The tree of the first plan, made as before a flight; no vehicle is heard."""
    run = Run(PreparedRun(prepare(mission), Recording()), Wire(), Telemetry(), 0.0)
    if failure := run.executive.plan():
        raise failure
    events = (stamped.event for stamped in run.flight.collect_reports())
    return next(event for event in events if isinstance(event, TreeBuilt))


def _in_words(node: PlanNode) -> str:
    return node.name if node.type is NodeType.LEAF else f"{node.type.value} {node.name}"
