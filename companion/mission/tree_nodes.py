"""The nodes of a behaviour tree written by hand; tree.py reads them, acting builds them."""

from __future__ import annotations

from dataclasses import dataclass

from companion.mission.facts import Fact


@dataclass(frozen=True, slots=True)
class Act:
    """An action by its name, e.g. "move(A, B)"."""

    action: str


@dataclass(frozen=True, slots=True)
class Check:
    """Facts that have to hold, and facts that must not; `text` as it was written."""

    text: str
    requires: frozenset[Fact]
    forbids: frozenset[Fact]


@dataclass(frozen=True, slots=True)
class Steps:
    """A sequence: its nodes one after the other, until one fails."""

    nodes: tuple[Tree, ...]


@dataclass(frozen=True, slots=True)
class Fallback:
    """A selector: its nodes one after the other, until one succeeds."""

    nodes: tuple[Tree, ...]


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
class Watch:
    """The steps while the facts hold; fails as soon as they do not."""

    condition: Check
    steps: Steps


def actions(node: Tree) -> set[str]:
    """Returns the names of the actions of a tree."""
    match node:
        case Act(name):
            return {name}
        case Steps(nodes) | Fallback(nodes):
            return set().union(*map(actions, nodes))
        case Repeat(steps) | Retry(steps) | Watch(_, steps):
            return actions(steps)
    return set()


Tree = Act | Check | Steps | Fallback | Repeat | Retry | Watch
