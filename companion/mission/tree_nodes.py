"""The nodes of a tree that was written by hand; tree.py reads them, acting builds them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Act:
    """An action by its grounded name, e.g. "move(A, B)"."""

    action: str


@dataclass(frozen=True, slots=True)
class Check:
    """Facts that have to hold, and facts that must not; `text` as it was written."""

    text: str
    requires: frozenset[str]
    forbids: frozenset[str]


@dataclass(frozen=True, slots=True)
class Steps:
    """One after the other, until one fails."""

    nodes: tuple[Tree, ...]


@dataclass(frozen=True, slots=True)
class Fallback:
    """The first that succeeds."""

    nodes: tuple[Tree, ...]


@dataclass(frozen=True, slots=True)
class Repeat:
    """A number of times, None for ever; fails when the steps fail."""

    steps: Steps
    times: int | None


@dataclass(frozen=True, slots=True)
class Retry:
    """Again after a failure, so often at most."""

    steps: Steps
    times: int


@dataclass(frozen=True, slots=True)
class Watch:
    """The steps while the facts hold; fails as soon as they do not."""

    condition: Check
    steps: Steps


def actions(node: Tree) -> set[str]:
    """The actions of a tree, by name."""
    match node:
        case Act(name):
            return {name}
        case Steps(nodes) | Fallback(nodes):
            return set().union(*map(actions, nodes))
        case Repeat(steps) | Retry(steps) | Watch(_, steps):
            return actions(steps)
    return set()


Tree = Act | Check | Steps | Fallback | Repeat | Retry | Watch
