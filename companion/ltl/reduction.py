"""How small does an automaton get? Reductions that keep the language.

They work on a bare graph: labels are sets of literal bits (two bits a proposition), marks sets
of acceptance sets, both as ints. Three steps are repeated until the size no longer changes:

- states from which nothing is accepted are dropped, and each strongly connected component
  keeps only the marks that say something inside it;
- a state *simulates* another if it can match each of its transitions by one with a weaker
  label, at least the same marks, and a target that simulates the target. States that simulate
  each other become one, and transitions that another one matches are dropped;
- labels are made disjoint where one more literal does it, so that fewer runs read a word; this
  often leaves states without a way to them.

Source: Etessami and Holzmann, Optimizing Büchi automata, CONCUR 2000; Somenzi and Bloem,
Efficient Büchi automata from LTL formulae, CAV 2000.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import or_
from typing import NamedTuple

from companion.ltl.automaton import strong_components

MAX_COMPARISONS = 5_000_000
"""Of edges with each other, and with nodes: about a second."""


class Edge(NamedTuple):
    """A transition; the source is known from where the edge is kept."""

    label: int
    marks: int
    target: int


@dataclass(frozen=True, slots=True)
class Graph:
    """An automaton; node 0 is initial.

    Attributes:
        edges: leaving each node.
        marks: number of acceptance sets.
    """

    edges: list[list[Edge]]
    marks: int

    @property
    def is_large(self) -> bool:
        """Whether comparing its nodes and edges as cubes would take long."""
        pairs = sum(len(leaving) ** 2 for leaving in self.edges)
        return pairs + len(self.edges) * self.size[1] > MAX_COMPARISONS

    @property
    def size(self) -> tuple[int, int, int]:
        """Nodes, edges, marks."""
        return (len(self.edges), sum(map(len, self.edges)), self.marks)


def reduced(graph: Graph) -> Graph:
    """An equivalent graph, usually smaller, with labels made disjoint."""
    rough = _settled(graph)
    while (finer := _settled(sharpened(rough))).size != rough.size:
        rough = finer
    return finer


def _settled(graph: Graph) -> Graph:
    while (smaller := merged(pruned(graph))).size != graph.size:
        graph = smaller
    return smaller


def minimal(
    sets: Iterable[int], spend: Callable[[int], None] = lambda comparisons: None
) -> list[int]:
    """The sets, as bits of an int, that have no other of the sets as a subset; smallest first.

    Args:
        spend: told how many comparisons come next.

    >>> minimal([0b111, 0b001, 0b110, 0b001])
    [1, 6]
    """
    kept: list[int] = []
    with_lowest: dict[int, list[int]] = defaultdict(list)  # the kept ones, by their lowest bit
    every_lowest = 0
    for bits in sorted(sets, key=int.bit_count):
        if not bits:
            return [0]
        candidates = [with_lowest[index] for index in indices(bits & every_lowest)]
        spend(1 + len(candidates) + sum(map(len, candidates)))
        if not any(other & bits == other for group in candidates for other in group):
            kept.append(bits)
            with_lowest[(bits & -bits).bit_length() - 1].append(bits)
            every_lowest |= bits & -bits
    return kept


def pruned(graph: Graph, departures_marked: bool = False) -> Graph:
    """Without nodes that accept nothing, and without marks that say nothing.

    Within a component a mark says nothing if every edge has it, or if some other mark is only
    found where it is found. A component with loops that cannot accept keeps none.

    Args:
        departures_marked: whether edges that leave a component which can accept have all marks;
            the language does not depend on the marks of edges between components.
    """
    every_mark = (1 << graph.marks) - 1
    component_of: dict[int, int] = {}
    essential: list[list[int] | None] = []  # for each component; None if it only rejects
    alive: set[int] = set()
    accepting: set[int] = set()
    for component in strong_components([[e.target for e in leaving] for leaving in graph.edges]):
        component_of.update(dict.fromkeys(component, len(essential)))
        leaving = [edge for node in component for edge in graph.edges[node]]
        inside = [e.marks for e in leaving if component_of.get(e.target) == len(essential)]
        is_accepting = bool(inside) and reduce(or_, inside) == every_mark
        only_rejects = bool(inside) and not is_accepting
        essential.append(None if only_rejects else essential_marks(inside, graph.marks))
        if is_accepting:
            accepting.add(len(essential) - 1)
        if is_accepting or any(edge.target in alive for edge in leaving):
            alive.update(component)
    marks = max(1 if kept is None else len(kept) for kept in essential)

    def renewed(edge: Edge, component: int) -> Edge:
        kept = essential[component]
        if kept is None or component_of[edge.target] != component:
            is_marked = departures_marked and component in accepting
            return edge._replace(marks=(1 << marks) - 1 if is_marked else 0)
        padded = [*kept, *[-1] * (marks - len(kept))]  # a mark on every edge says nothing
        bits = sum(1 << i for i, mark in enumerate(padded) if edge.marks & mark or mark == -1)
        return edge._replace(marks=bits)

    return reachable(
        [
            [renewed(edge, component_of[node]) for edge in leaving if edge.target in alive]
            for node, leaving in enumerate(graph.edges)
        ],
        marks,
    )


def essential_marks(inside: list[int], marks: int) -> list[int]:
    """The marks (as bits) that matter in a component, given those of its edges."""
    kinds = sorted(set(inside))
    where = {
        sum(1 << i for i, kind in enumerate(kinds) if kind >> mark & 1): 1 << mark
        for mark in reversed(range(marks))
    }
    everywhere = (1 << len(kinds)) - 1
    return sorted(where[places] for places in minimal(where) if places != everywhere)


def reachable(edges: Sequence[Sequence[Edge]], marks: int, start: int = 0) -> Graph:
    """The graph of what a node reaches, renumbered in the order in which it is met."""
    number_of = {start: 0}
    pending = [start]
    kept = []
    for node in pending:  # grows while it is read
        for edge in edges[node]:
            if edge.target not in number_of:
                number_of[edge.target] = len(number_of)
                pending.append(edge.target)
        kept.append([edge._replace(target=number_of[edge.target]) for edge in edges[node]])
    return Graph(kept, marks)


def simulation(graph: Graph) -> list[int]:
    """For each node the set (bits) of the nodes that simulate it; the greatest such relation."""
    sources: dict[tuple[int, int], dict[int, int]] = defaultdict(lambda: defaultdict(int))
    for node, leaving in enumerate(graph.edges):
        for edge in leaving:
            sources[edge.label, edge.marks][edge.target] |= 1 << node
    simulators = [(1 << len(graph.edges)) - 1] * len(graph.edges)
    matching = {kind: _matching(sources, *kind) for kind in sources}
    is_stable = False
    while not is_stable:
        is_stable = True
        for kind, by_target in sources.items():
            able_by_target = matching[kind]
            for target, nodes in by_target.items():
                able = 0  # nodes with a matching edge
                for candidate in indices(simulators[target]):
                    able |= able_by_target.get(candidate, 0)
                for node in indices(nodes):
                    if simulators[node] & ~able:
                        simulators[node] &= able
                        is_stable = False
    return simulators


def _matching(
    sources: dict[tuple[int, int], dict[int, int]], label: int, marks: int
) -> dict[int, int]:
    """For each target the nodes (bits) with an edge to it of a weaker label and these marks."""
    able: dict[int, int] = defaultdict(int)
    for (weaker, more), by_target in sources.items():
        if weaker & label == weaker and more & marks == marks:
            for target, nodes in by_target.items():
                able[target] |= nodes
    return able


def merged(graph: Graph) -> Graph:
    """One node for all that simulate each other, and no edge that another one matches."""
    simulators = simulation(graph)
    leader = [
        next(i for i in indices(above) if simulators[i] >> node & 1)
        for node, above in enumerate(simulators)
    ]
    edges = []
    for leaving in graph.edges:
        kept: list[Edge] = []
        candidates = {edge._replace(target=leader[edge.target]) for edge in leaving}
        for edge in sorted(candidates):
            if not any(other != edge and _matches(other, edge, simulators) for other in candidates):
                kept.append(edge)
        edges.append(kept)
    return reachable(edges, graph.marks)


def _matches(stronger: Edge, edge: Edge, simulators: list[int]) -> bool:
    """Whether a run may take the first edge wherever it may take the second."""
    return (
        stronger.label & edge.label == stronger.label
        and stronger.marks & edge.marks == edge.marks
        and bool(simulators[edge.target] >> stronger.target & 1)
    )


def sharpened(graph: Graph) -> Graph:
    """With labels that exclude what a better edge reads, where one more literal says so."""
    simulators = simulation(graph)
    edges = []
    for leaving in graph.edges:
        sharp = list(leaving)
        for i, edge in enumerate(sharp):
            for better in sharp[:i] + sharp[i + 1 :]:
                excess = better.label & ~sharp[i].label
                if excess.bit_count() == 1 and _matches(better._replace(label=0), edge, simulators):
                    sharp[i] = sharp[i]._replace(label=sharp[i].label | _negation(excess))
        edges.append(sharp)
    return Graph(edges, graph.marks)


def _negation(literal: int) -> int:
    """The bit of the negated literal: literals come in pairs p, !p from bit 0."""
    return literal >> 1 if literal.bit_length() % 2 == 0 else literal << 1


def indices(bits: int) -> Iterator[int]:
    """Positions of the bits that are set, lowest first."""
    while bits:
        lowest = bits & -bits
        yield lowest.bit_length() - 1
        bits ^= lowest
