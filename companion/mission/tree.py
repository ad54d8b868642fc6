"""A plan written by hand: the behaviour tree of a mission file (Section IV-A of the paper).

    text                        an action of a skill, `move(A, B)`, or facts to hold, `lit & !late`
    wait(seconds)               succeeds after a time
    [node, ...]                 one after the other, until one fails
    {fallback: [node, ...]}     one after the other, until one succeeds
    {parallel: [node, ...]}     all at once, until all have succeeded or one has failed
    {inverter: [node, ...]}     the sequence, with success and failure exchanged
    {repeat: [node, ...]}       the sequence for ever, or `times` times; ends when it fails
    {retry: [node, ...], times: n}      the sequence, at most n times, until it succeeds
    {timeout: [node, ...], duration_s: s}       the sequence, which fails after a time
    {watch: facts, do: [node, ...]}     the sequence while the facts hold, else interrupted
    {subtree: name}             the sequence of that name under `subtrees`

The names are those of py_trees and BehaviorTree.CPP where these agree. After an interrupted flight
the vehicle is between places, at `here`: `move(here, B)` flies on from there, and `move(*, B)`
begins wherever the vehicle is.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from companion.documents import Document, did_you_mean
from companion.errors import Keys, MissionError
from companion.mission.parts import MissionParts
from companion.mission.tree_leaves import LeafReader
from companion.mission.tree_nodes import (
    Fallback,
    Inverter,
    Parallel,
    Repeat,
    Retry,
    Steps,
    Subtree,
    Timeout,
    Tree,
    Watch,
    actions,
    children,
)

FORMS: Mapping[str, frozenset[str]] = {
    "fallback": frozenset({"fallback"}),
    "parallel": frozenset({"parallel"}),
    "inverter": frozenset({"inverter"}),
    "repeat": frozenset({"repeat", "times"}),
    "retry": frozenset({"retry", "times"}),
    "timeout": frozenset({"timeout", "duration_s"}),
    "watch": frozenset({"watch", "do"}),
    "subtree": frozenset({"subtree"}),
}
"""The kinds of nodes that are written as tables, each with its keys."""
MAX_NODES = 2000
"""Limits the nodes, because a tree is ticked 20 times a second and nested subtrees multiply."""
MAX_NESTED = 8
"""Limits how deep subtrees may be nested."""
_HINT = f"a node is a text, a list, or one of {', '.join([*FORMS][:-1])} and {[*FORMS][-1]}"


class Extent(NamedTuple):
    """The size of a tree: its nodes, and how deep its subtrees are nested."""

    nodes: int
    nested: int


def read_tree(
    data: object, subtrees: Mapping[str, object], document: Document, parts: MissionParts
) -> Tree:
    """Reads the tree under the key `tree`, and all subtrees.

    Args:
        data: the value of the key.
        subtrees: the subtrees as they are written, by name.
        document: the document that contains all of it.
        parts: the parts of the mission, whose skills and facts the tree uses.

    Raises:
        MissionError: with the place of the first unusable node.
    """
    reader = _WrittenTreeReader(document, subtrees, LeafReader(document, parts, _HINT))
    for name in subtrees:
        reader.subtree(name, ("subtrees", name), ())
    tree = reader.node(data, ("tree",), ())
    reader.check_extent(tree, ("tree",))
    return tree


@dataclass(frozen=True, slots=True)
class _WrittenTreeReader:
    """Reads nodes; `within` are the subtrees around a node, the outermost first."""

    document: Document
    subtrees: Mapping[str, object]
    leaves: LeafReader
    known: dict[str, Subtree] = field(default_factory=dict)
    extents: dict[str, Extent] = field(default_factory=dict)

    def node(self, data: object, keys: Keys, within: tuple[str, ...]) -> Tree:
        if isinstance(data, str):
            return self.leaves.read(data, keys)
        if isinstance(data, list) and data:
            return Steps(tuple(self.node(d, (*keys, i), within) for i, d in enumerate(data)))
        if isinstance(data, dict):
            return self._table(data, keys, within)
        raise self._error("not a node of a tree", keys)

    # -- subtrees ------------------------------------------------------------------------------

    def subtree(self, name: str, keys: Keys, within: tuple[str, ...]) -> Subtree:
        """The subtree with this name, as it is used at `keys`."""
        if name in within:
            path = " -> ".join([*within[within.index(name) :], name])
            raise MissionError(
                f"the subtree {name} is a part of itself: {path}",
                self.document.where(*keys),
                "a tree has to end in actions and facts; for what is done again there is repeat",
            )
        if name not in self.known:
            self._check_nested(len(within) + 1, keys)
            own: Keys = ("subtrees", name)
            subtree = Subtree(name, self._steps(self.subtrees[name], own, (*within, name)))
            self.check_extent(subtree, own)
            self.known[name], self.extents[name] = subtree, self._extent(subtree)
        return self.known[name]

    def check_extent(self, tree: Tree, keys: Keys) -> None:
        """Refuses a tree that would be too large to tick."""
        extent = self._extent(tree)
        self._check_nested(extent.nested, keys)
        if extent.nodes > MAX_NODES:
            raise MissionError(
                f"{extent.nodes} nodes, with those of subtrees; a tree has at most {MAX_NODES}",
                self.document.where(*keys),
                "use fewer nested subtrees",
            )

    def _check_nested(self, nested: int, keys: Keys) -> None:
        if nested > MAX_NESTED:
            where = self.document.where(*keys)
            what = f"more than {MAX_NESTED} nested subtrees"
            raise MissionError(what, where, "write the inner ones out")

    def _extent(self, tree: Tree) -> Extent:
        if isinstance(tree, Subtree) and tree.name in self.extents:
            return self.extents[tree.name]
        below = [self._extent(child) for child in children(tree)]
        nested = max((extent.nested for extent in below), default=0)
        return Extent(1 + sum(extent.nodes for extent in below), nested + isinstance(tree, Subtree))

    # -- tables --------------------------------------------------------------------------------

    def _table(self, data: Mapping[str, object], keys: Keys, within: tuple[str, ...]) -> Tree:
        kind = next((kind for kind in FORMS if kind in data), None)
        if kind is None:
            name = next(iter(data), "")
            hint = f"{_HINT}. {did_you_mean(str(name), FORMS)}".rstrip()
            raise MissionError(f"unknown node {name}", self.document.where(*keys), hint)
        for key in data:
            if key not in FORMS[kind]:
                what = f"{kind} has no key {key}"
                hint = f"its keys are {', '.join(sorted(FORMS[kind]))}"
                raise MissionError(what, self.document.where(*keys, key), hint)
        if kind == "subtree":
            return self._named(data[kind], (*keys, kind), within)
        if kind == "watch":
            facts = data[kind]
            if not isinstance(facts, str):
                raise self._error("watch needs facts", (*keys, kind))
            condition = self.leaves.facts(facts, (*keys, kind))
            return Watch(condition, self._steps(data.get("do"), (*keys, "do"), within))
        steps = self._steps(data[kind], (*keys, kind), within)
        match kind:
            case "fallback":
                return Fallback(steps.nodes)
            case "parallel":
                return self._parallel(steps, (*keys, kind))
            case "inverter":
                return Inverter(steps)
            case "timeout":
                return Timeout(steps, self._duration_s(data, keys))
            case "retry":
                return Retry(steps, self._times(data, kind, keys))
        return Repeat(steps, self._times(data, kind, keys) if "times" in data else None)

    def _steps(self, data: object, keys: Keys, within: tuple[str, ...]) -> Steps:
        node = self.node(data, keys, within)
        return node if isinstance(node, Steps) else Steps((node,))

    def _times(self, data: Mapping[str, object], kind: str, keys: Keys) -> int:
        times = data.get("times")
        if not isinstance(times, int) or isinstance(times, bool) or times < 1:
            raise self._error(f"{kind} needs times: a whole number, 1 or more", (*keys, "times"))
        return times

    def _duration_s(self, data: Mapping[str, object], keys: Keys) -> float:
        seconds = data.get("duration_s")
        is_number = isinstance(seconds, int | float) and not isinstance(seconds, bool)
        if not is_number or not 0 < seconds < math.inf:  # type: ignore[operator]
            what = "timeout needs duration_s: seconds, more than 0"
            raise self._error(what, (*keys, "duration_s"))
        return float(seconds)  # type: ignore[arg-type]

    def _named(self, name: object, keys: Keys, within: tuple[str, ...]) -> Subtree:
        if not isinstance(name, str) or name not in self.subtrees:
            listing = ", ".join(self.subtrees) or "none yet"
            hint = f"subtrees are {listing}. {did_you_mean(str(name), self.subtrees)}".rstrip()
            raise MissionError(f"unknown subtree {name}", self.document.where(*keys), hint)
        return self.subtree(name, keys, within)

    def _parallel(self, steps: Steps, keys: Keys) -> Parallel:
        """Refuses actions in two branches, because the vehicle can only do one at a time."""
        acting = [i for i, branch in enumerate(steps.nodes) if actions(branch)]
        if len(acting) > 1:
            one, other = (min(actions(steps.nodes[i])) for i in acting[:2])
            raise MissionError(
                f"two branches of a parallel fly or command at the same time: {one} and {other}",
                self.document.where(*keys, acting[1]),
                "the vehicle does one action at a time: put them one after the other, and beside "
                "them facts to check, and waits",
            )
        return Parallel(steps.nodes)

    def _error(self, what: str, keys: Keys) -> MissionError:
        return MissionError(what, self.document.where(*keys), _HINT)
