"""How small does an automaton get if its labels are sets of letters? Simulation both ways.

A node *simulates* another if it can match every edge of it, letter by letter: by an edge that
reads the letter, has at least the same marks, and leads to a node that simulates the target.
Backwards the same holds for the edges into a node. Nodes that simulate each other become one,
and an edge loses the letters that a better edge reads, which leaves few runs a word.

Source: Etessami and Holzmann, Optimizing Büchi automata, CONCUR 2000; Somenzi and Bloem,
Efficient Büchi automata from LTL formulae, CAV 2000; Clemente and Mayr, Advanced automata
minimization, POPL 2013, for the edges that may be dropped.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from functools import partial

from companion.ltl.automaton import strong_components
from companion.ltl.budget import Budget, TranslationLimit
from companion.ltl.reduction import Edge, Graph, indices, pruned, reachable
from companion.ltl.simulation import Signature, equals, leaders, signature_of, simulators

MAX_STATES_TWICE = 100
"""States up to which a graph is reduced in both ways, to take the smaller result."""

Relation = Callable[[Sequence[Sequence[Edge]], Sequence[int]], list[int]]
"""Which nodes can stand for each node, as bits: `simulators`, or `equals`, which is quicker."""


def smallest(graph: Graph, budget: Budget) -> Graph:
    """An equivalent graph, usually smaller; if the budget is spent, not as small as it could be.

    Edges between components may have any marks, and no choice is best for all automata.
    """
    first = _simulated(graph, False, budget)
    if not 1 < len(first.edges) <= MAX_STATES_TWICE:
        return first
    second = _simulated(graph, True, budget)
    return first if first.size <= second.size else pruned(second)


def _simulated(graph: Graph, departures_marked: bool, budget: Budget) -> Graph:
    best = pruned(graph, departures_marked)
    try:
        for relation in (equals, simulators):
            best = _reduced(best, departures_marked, partial(relation, budget=budget))
    except TranslationLimit:
        pass  # what was found so far is right as well
    return best


def _reduced(graph: Graph, departures_marked: bool, relation: Relation) -> Graph:
    while True:
        smaller = pruned(merged(graph, relation), departures_marked)
        smaller = pruned(merged_backwards(smaller, (), relation), departures_marked)
        if smaller.size == graph.size:
            return smaller  # its labels are sharper
        graph = smaller


def merged(graph: Graph, relation: Relation) -> Graph:
    """One node for all that simulate each other; no letter on an edge if a better one reads it."""
    above = relation(graph.edges, [0] * len(graph.edges))
    leader = leaders(above)
    edges = [_best(signature_of(leaving, leader), above) for leaving in graph.edges]
    chosen = _descended(edges, above, leader)
    return reachable([_joined(leaving, chosen) for leaving in edges], graph.marks, chosen[0])


def merged_backwards(graph: Graph, colours: Sequence[int], relation: Relation) -> Graph:
    """The same for the edges into nodes.

    Args:
        colours: bits that a node must have to stand for one that has them; () for none.
    """
    size = len(graph.edges)
    entering: list[list[Edge]] = [[] for _ in range(size)]
    for node, leaving in enumerate(graph.edges):
        for label, marks, target in leaving:
            entering[target].append(Edge(label, marks, node))
    is_initial = [1] + [0] * (size - 1)
    shades = [2 * c + i for c, i in zip(colours or [0] * size, is_initial, strict=True)]
    above = relation(entering, shades)
    leader = leaders(above)
    united: list[list[Edge]] = [[] for _ in range(size)]
    for node, arriving in enumerate(entering):
        united[leader[node]] += arriving
    edges: list[list[Edge]] = [[] for _ in range(size)]
    for target, arriving in enumerate(united):
        for label, marks, source in _best(signature_of(arriving, leader), above):
            edges[source].append(Edge(label, marks, target))
    return reachable(edges, graph.marks, leader[0])


def _joined(leaving: Iterable[Edge], leader: Sequence[int]) -> list[Edge]:
    """One edge for all with the same marks to the same leader."""
    return [
        Edge(letters, marks, target)
        for (marks, target), letters in signature_of(leaving, leader).items()
    ]


def _best(signature: Signature, above: Sequence[int]) -> list[Edge]:
    """The edges of a signature, each without the letters that a better one reads."""
    edges = [Edge(letters, *kind) for kind, letters in signature.items()]
    if not overlap(edges):
        return edges
    edges_at: dict[int, list[Edge]] = defaultdict(list)
    for edge in edges:
        edges_at[edge.target].append(edge)
    present = sum(1 << target for target in edges_at)
    kept = []
    for edge in edges:
        rest = edge.label
        for target in indices(above[edge.target] & present):
            for other in edges_at[target]:
                if edge.marks & ~other.marks == 0 and other is not edge:
                    rest &= ~other.label
        if rest:
            kept.append(edge._replace(label=rest))
    return kept


def _descended(
    edges: Sequence[Sequence[Edge]], above: Sequence[int], leader: Sequence[int]
) -> list[int]:
    """For each node its leader, or a node further down that accepts the same.

    The marks of a single edge do not matter. So two nodes whose edges match, but for the marks
    on them, accept the same words; the second can take the place of the first if it never leads
    back to it.
    """
    first_with: dict[frozenset[Edge], int] = {}
    chosen = list(leader)
    for component in strong_components([[edge.target for edge in leaving] for leaving in edges]):
        steps = {
            node: frozenset(
                _best(signature_of((e._replace(marks=0) for e in edges[node]), leader), above)
            )
            for node in component
            if leader[node] == node
        }
        for node, step in steps.items():
            chosen[node] = first_with.get(step, node)
        for node, step in steps.items():
            first_with.setdefault(step, node)
    return [chosen[node] for node in leader]


def is_deterministic(graph: Graph) -> bool:
    """Whether no letter has two edges at a node."""
    return not any(map(overlap, graph.edges))


def overlap(edges: Iterable[Edge]) -> bool:
    """Whether a letter has two of the edges."""
    read = 0
    for edge in edges:
        if read & edge.label:
            return True
        read |= edge.label
    return False
