"""Behaviour trees of plans: the first plan of a mission, or the last one ticked in a run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from companion.acting.assembly import flight_of
from companion.acting.behaviour_tree.builder import build
from companion.acting.behaviour_tree.hand_built import build_by_hand
from companion.acting.behaviour_tree.tree_report import described
from companion.acting.contingencies.hypothetical_vehicle import HypotheticalVehicle
from companion.acting.preparation import prepare
from companion.acting.replanning.assumptions import Assumptions
from companion.api.results import FlightResult
from companion.api.tree_xml import to_xml
from companion.arguments import path_of
from companion.errors import MissionError
from companion.flight_events.tree import NodeType, PlanNode
from companion.mission.model import Mission
from companion.planning.lasso import ChosenPlan
from companion.record.events import read_events, record_of

_SHAPES = {NodeType.ACTION: "box", NodeType.LEAF: "box"}
"""Shapes in the DOT language; all other nodes are ellipses."""


@dataclass(frozen=True, slots=True)
class BehaviourTree:
    """A behaviour tree as the executive ticks it.

    Attributes:
        nodes: depth first, each with its depth; the first one is the root, with depth 0.
    """

    nodes: tuple[PlanNode, ...]

    def to_text(self) -> str:
        """A line for each node, indented by its depth: type and name."""
        return "".join(f"{'  ' * node.depth}{_in_words(node)}\n" for node in self.nodes)

    def to_dot(self) -> str:
        """The tree as a directed graph in the DOT language of Graphviz."""
        lines = ["digraph tree {", "  ordering=out"]
        path: list[int] = []  # the nodes from the root to the current one
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
        of: a mission, for the tree of its first plan or the tree that it brings; or a run folder,
            or a result of `simulate` or `run`, for the last tree that was ticked.

    Raises:
        NoPlan: the mission has no plan; `explanation` says why.
        SearchLimit: the search for a plan was given up.
        MissionError: it is no run folder, a line of it is damaged, or nothing was flown.
        CompanionError: `of` is of another type.
    """
    if isinstance(of, Mission):
        return BehaviourTree(_planned(of))
    if isinstance(of, FlightResult):
        record = record_of(of.events)
    else:
        record = read_events(path_of(of, "a mission, a flight, or a run folder"))
    if record.tree is None:
        raise MissionError("no behaviour tree was ticked in this run")
    return BehaviourTree(record.tree.nodes)


def _planned(mission: Mission) -> tuple[PlanNode, ...]:
    """The tree of the first plan, or the mission's own tree; it is not ticked."""
    prepared = prepare(mission)
    planner, first = prepared.planner, prepared.first_plan
    flight = flight_of(prepared, HypotheticalVehicle(mission.home.position))
    if mission.tree is not None:
        return described(build_by_hand(flight, mission.tree, planner.actions.of_tree(mission.tree)))
    assert first is not None, "a mission without a tree of its own"
    if not isinstance(first.outcome, ChosenPlan):
        raise first.outcome
    return described(build(flight, first.outcome.lasso, Assumptions(planner, flight)))


def _in_words(node: PlanNode) -> str:
    return node.name if node.type is NodeType.LEAF else f"{node.type.value} {node.name}"
