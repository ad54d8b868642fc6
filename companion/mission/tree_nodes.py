"""The nodes of a behaviour tree written by hand: tree.py reads them, acting/ builds them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from companion.mission.facts import Fact


@dataclass(frozen=True, slots=True)
class Act:
    """An action by name, e.g. "move(A, B)"; `*` stands for wherever the vehicle is."""

    action: str


@dataclass(frozen=True, slots=True)
class Check:
    """Facts that have to hold, and facts that must not; `text` is how the mission writes them."""

    text: str
    requires: frozenset[Fact]
    forbids: frozenset[Fact]


@dataclass(frozen=True, slots=True)
class WaitFor:
    """Succeeds after a time."""

    duration_s: float


@dataclass(frozen=True, slots=True)
class Steps:
    """A sequence: its nodes one after the other, until one fails."""

    nodes: tuple[Tree, ...]


@dataclass(frozen=True, slots=True)
class Fallback:
    """A selector: its nodes one after the other, until one succeeds."""

    nodes: tuple[Tree, ...]


@dataclass(frozen=True, slots=True)
class Parallel:
    """Runs all nodes at once; succeeds when all have succeeded, fails as soon as one does."""

    nodes: tuple[Tree, ...]


@dataclass(frozen=True, slots=True)
class Inverter:
    """Runs the steps; fails when they succeed, and succeeds when they fail."""

    steps: Steps


@dataclass(frozen=True, slots=True)
class Repeat:
    """Runs the steps a number of times (None: for ever); fails when they fail."""

    steps: Steps
    times: int | None


@dataclass(frozen=True, slots=True)
class Retry:
    """Runs the steps again after a failure, up to a number of times."""

    steps: Steps
    times: int


@dataclass(frozen=True, slots=True)
class Timeout:
    """Runs the steps; after a time it interrupts them and fails."""

    steps: Steps
    duration_s: float


@dataclass(frozen=True, slots=True)
class Watch:
    """Runs the steps while the facts hold; fails as soon as they do not."""

    condition: Check
    steps: Steps


@dataclass(frozen=True, slots=True)
class Subtree:
    """Steps to which the mission has given a name."""

    name: str
    steps: Steps


Tree = (
    Act
    | Check
    | WaitFor
    | Steps
    | Fallback
    | Parallel
    | Inverter
    | Repeat
    | Retry
    | Timeout
    | Watch
    | Subtree
)


def children(node: Tree) -> tuple[Tree, ...]:
    """Returns the nodes right below a node."""
    match node:
        case Steps(nodes) | Fallback(nodes) | Parallel(nodes):
            return nodes
        case Watch(condition, steps):
            return (condition, steps)
        case Inverter(steps) | Repeat(steps) | Retry(steps) | Timeout(steps) | Subtree(_, steps):
            return (steps,)
    return ()


def nodes_of(node: Tree) -> Iterator[Tree]:
    """A node and all below it, depth first."""
    yield node
    for child in children(node):
        yield from nodes_of(child)


def actions(node: Tree) -> set[str]:
    """Returns the names of the actions of a tree."""
    return {each.action for each in nodes_of(node) if isinstance(each, Act)}
