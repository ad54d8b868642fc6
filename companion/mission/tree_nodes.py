"""The nodes of a behaviour tree written by hand; tree.py reads them, acting builds them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from companion.mission.facts import Fact


@dataclass(frozen=True, slots=True)
class Act:
    """An action by its name, e.g. "move(A, B)"; `*` is wherever the vehicle is."""

    action: str


@dataclass(frozen=True, slots=True)
class Check:
    """Facts that have to hold, and facts that must not; `text` as it was written."""

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
    """All nodes at a time; succeeds when all have succeeded, fails as soon as one does."""

    nodes: tuple[Tree, ...]


@dataclass(frozen=True, slots=True)
class Inverter:
    """The steps; fails when they succeed, and succeeds when they fail."""

    steps: Steps


@dataclass(frozen=True, slots=True)
class Repeat:
    """The steps a number of times, None for ever; fails when they fail."""

    steps: Steps
    times: int | None


@dataclass(frozen=True, slots=True)
class Retry:
    """The steps again after a failure, so many times at most."""

    steps: Steps
    times: int


@dataclass(frozen=True, slots=True)
class Timeout:
    """The steps; interrupted, and a failure, after a time."""

    steps: Steps
    duration_s: float


@dataclass(frozen=True, slots=True)
class Watch:
    """The steps while the facts hold; fails as soon as they do not."""

    condition: Check
    steps: Steps


@dataclass(frozen=True, slots=True)
class Subtree:
    """Steps that the mission has given a name."""

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
