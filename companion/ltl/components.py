"""Strongly connected components of a graph, and which nodes can reach which of them.

Source: Tarjan, Depth-first search and linear graph algorithms, 1972; with an explicit stack, so a
long path causes no deep recursion.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from typing import TypeVar

K = TypeVar("K", bound=Hashable)


def strong_components(successors: Sequence[Iterable[int]]) -> list[list[int]]:
    """Strongly connected components; each comes after all those that it can reach.

    Args:
        successors: those of each node; nodes are numbered from 0.

    >>> strong_components([[1], [0, 2], []])
    [[2], [1, 0]]
    """
    index: dict[int, int] = {}
    lowest: dict[int, int] = {}
    open_nodes: list[int] = []
    components: list[list[int]] = []
    closed = len(successors) + 1  # larger than any index
    for root in range(len(successors)):
        if root in index:
            continue
        pending = [(root, iter(successors[root]))]
        index[root] = lowest[root] = len(index)
        open_nodes.append(root)
        while pending:
            node, targets = pending[-1]
            for target in targets:
                if target not in index:
                    index[target] = lowest[target] = len(index)
                    open_nodes.append(target)
                    pending.append((target, iter(successors[target])))
                    break
                lowest[node] = min(lowest[node], lowest[target])
            else:
                pending.pop()
                if pending:
                    lowest[pending[-1][0]] = min(lowest[pending[-1][0]], lowest[node])
                if lowest[node] == index[node]:
                    component = [open_nodes.pop()]
                    while component[-1] != node:
                        component.append(open_nodes.pop())
                    lowest.update(dict.fromkeys(component, closed))
                    components.append(component)
    return components


def components_by_name(successors: Mapping[K, Sequence[K]]) -> list[list[K]]:
    """Strongly connected components of named nodes; successors without an entry are ignored.

    >>> components_by_name({"a": ["b"], "b": ["a", "elsewhere"]})
    [['b', 'a']]
    """
    names = list(successors)
    number_of = {name: number for number, name in enumerate(names)}
    components = strong_components(
        [[number_of[t] for t in successors[name] if t in number_of] for name in names]
    )
    return [[names[number] for number in component] for component in components]


def acyclic(successors: Mapping[K, Sequence[K]]) -> set[K]:
    """The nodes that are on no cycle; successors without an entry are ignored.

    >>> sorted(acyclic({"a": ["a", "b"], "b": ["c"], "c": []}))
    ['b', 'c']
    """
    return {
        name
        for component in components_by_name(successors)
        for name in component
        if not (component[1:] or name in successors[name])
    }


def reaching(
    successors: Sequence[Iterable[int]],
    components: Iterable[Sequence[int]],
    accepting: Iterable[bool],
) -> set[int]:
    """The nodes from which an accepting component can be reached.

    Args:
        components: as `strong_components` returns them.
        accepting: whether each component is accepting.

    >>> graph = [[0, 1], [1], [2]]
    >>> components = strong_components(graph)
    >>> sorted(reaching(graph, components, [component == [1] for component in components]))
    [0, 1]
    """
    found: set[int] = set()
    for component, is_accepting in zip(components, accepting, strict=True):
        if is_accepting or any(t in found for node in component for t in successors[node]):
            found.update(component)
    return found
