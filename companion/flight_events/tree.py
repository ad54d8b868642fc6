"""Events about the behaviour tree: which one is ticked, and what its nodes do."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Annotated, NamedTuple

from companion.flight_events.event import FlightEvent
from companion.flight_events.event_fields import Doc


class NodeType(Enum):
    """What a node is; a reactive sequence begins with its first child in every tick."""

    ACTION = "action"
    SEQUENCE = "sequence"
    REACTIVE_SEQUENCE = "reactive_sequence"
    SELECTOR = "selector"
    PARALLEL = "parallel"
    SUBTREE = "subtree"
    REPEAT = "repeat"
    RETRY = "retry"
    INVERTER = "inverter"
    TIMEOUT = "timeout"
    LEAF = "leaf"


class LeafType(Enum):
    """What a leaf does."""

    ASSUMPTIONS = "assumptions"
    PRECONDITION = "precondition"
    EFFECTS = "effects"
    WITHDRAW = "withdraw"
    UPDATE_PARAM = "update_param"
    MOVE_CMD = "move_cmd"
    LOOK_AT = "look_at"
    COMMAND = "command"
    PHOTO = "photo"
    GIMBAL = "gimbal"
    CONFIRM = "confirm"
    PYTHON = "python"
    WAIT = "wait"
    LAND = "land"
    LAND_ON = "land_on"
    TAKE_OFF = "take_off"
    CHARGE = "charge"
    BEGIN_AGAIN = "begin_again"
    FACTS = "facts"
    STILL_THERE = "still_there"


class NodeStatus(Enum):
    """What a node does; py_trees' names."""

    INVALID = "INVALID"
    RUNNING = "RUNNING"
    SUCCESS = "SUCCESS"
    FAILURE = "FAILURE"


@dataclass(frozen=True, slots=True)
class TreeNode:
    """A node of a tree."""

    depth: Annotated[int, Doc("how far it stands below the root")]
    type: Annotated[NodeType, Doc("what it is")]
    name: Annotated[str, Doc("as people know it")]


@dataclass(frozen=True, slots=True)
class ActionTreeNode(TreeNode):
    """A node with an action of the plan below it."""

    destination: Annotated[str | None, Doc("the place that it flies to, or null")]
    assumes: Annotated[tuple[str, ...], Doc("the beliefs that it relies on")]


@dataclass(frozen=True, slots=True)
class CountedTreeNode(TreeNode):
    """A node that repeats what is below it: after a success, or after a failure."""

    times: Annotated[int | None, Doc("how often at most; null is for ever")]


@dataclass(frozen=True, slots=True)
class TimedTreeNode(TreeNode):
    """A node that limits the time of what is below it."""

    duration_s: Annotated[float, Doc("seconds that it may take")]


@dataclass(frozen=True, slots=True)
class LeafTreeNode(TreeNode):
    """A node with nothing below it."""

    does: Annotated[LeafType, Doc("what it does")]


PlanNode = ActionTreeNode | CountedTreeNode | TimedTreeNode | LeafTreeNode | TreeNode
"""A node of any kind."""


class NodeChange(NamedTuple):
    """A node that has another status.

    Attributes:
        node: its place among the tree's nodes, from 0.
        feedback: what a leaf says about it.
    """

    node: int
    status: NodeStatus
    feedback: str


Changes = Annotated[
    tuple[NodeChange, ...],
    Doc(
        "a list of the node's number (its place in `nodes`, from 0), its status as py_trees names "
        "it, and what a leaf says about it"
    ),
]


@dataclass(frozen=True, slots=True)
class TreeBuilt(FlightEvent):
    """A new behaviour tree is ticked from now on."""

    kind = "tree"
    template = "a tree of {size} nodes"
    is_told = False

    nodes: Annotated[
        tuple[PlanNode, ...],
        Doc(
            "depth first, each with `depth`, `type` and `name`; an `action` also with its "
            "`destination` (a place, or null) and what it `assumes`, a `repeat` or `retry` with "
            "how many `times` at most (null is for ever), a `timeout` with its `duration_s`, a "
            "`leaf` with what it `does`"
        ),
    ]

    @property
    def size(self) -> int:
        """The number of its nodes."""
        return len(self.nodes)


@dataclass(frozen=True, slots=True)
class NodesChanged(FlightEvent):
    """Nodes of the tree changed their status; the text names the node that was ticked last."""

    kind = "status"
    template = "{tip}: {tip_status}"
    is_told = False

    tip: Annotated[str, Doc("the node that was ticked last")]
    tip_status: Annotated[NodeStatus, Doc("its status")]
    changed: Changes


@dataclass(frozen=True, slots=True)
class TreeStopped(FlightEvent):
    """The tree is no longer ticked."""

    kind = "status"
    template = "nothing runs"
    is_told = False

    changed: Changes
