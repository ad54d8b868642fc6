"""Quotients: merge nodes that simulate each other, and drop edges that better ones cover.

A relation says what can be merged: simulation, or bisimulation, which is quicker to find. An edge
loses the letters that a better edge reads, so a word has few runs. Backwards, the same is done with
the edges into a node.

Source: Etessami and Holzmann, Optimizing Büchi automata, CONCUR 2000; Somenzi and Bloem,
Efficient Büchi automata from LTL formulae, CAV 2000; Clemente and Mayr, Advanced automata
minimization, POPL 2013, for the edges that may be dropped.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence

from companion.ltl.bitsets import indices
from companion.ltl.budget import Budget
from companion.ltl.components import strong_components
from companion.ltl.graph import LabelledEdge, LabelledGraph, Nodes, overlap, reachable, renumbered
from companion.ltl.labels import Cube, LetterSet
from companion.ltl.reductions.bisimulation import Arrows, Signature, redirected, signature
from companion.ltl.reductions.simulation import leaders, ordered, simulators

Relation = Callable[[Arrows, Sequence[int]], list[Nodes]]
"""Finds for each node those that can stand for it: its simulators, or the nodes bisimilar to it."""


def merged(graph: LabelledGraph[LetterSet], relation: Relation) -> LabelledGraph[LetterSet]:
    """The quotient of a graph by a relation on the edges that leave nodes."""
    above = relation(graph.edges, [0] * len(graph.edges))
    leader = leaders(above)
    edges = [_uncovered(signature(leaving, leader), above) for leaving in graph.edges]
    chosen = _descended(edges, above, leader)
    return reachable([redirected(leaving, chosen) for leaving in edges], graph.marks, chosen[0])


def merged_backwards(
    graph: LabelledGraph[LetterSet], colours: Sequence[int], relation: Relation
) -> LabelledGraph[LetterSet]:
    """The quotient of a graph by a relation on the edges that enter nodes.

    Args:
        colours: bits that a node must have to stand for another one with them; () for none.
    """
    size = len(graph.edges)
    entering: list[list[LabelledEdge[LetterSet]]] = [[] for _ in range(size)]
    for node, leaving in enumerate(graph.edges):
        for label, marks, target in leaving:
            entering[target].append(LabelledEdge(label, marks, node))
    is_initial = [1] + [0] * (size - 1)
    shades = [2 * c + i for c, i in zip(colours or [0] * size, is_initial, strict=True)]
    above = relation(entering, shades)
    leader = leaders(above)
    united: list[list[LabelledEdge[LetterSet]]] = [[] for _ in range(size)]
    for node, arriving in enumerate(entering):
        united[leader[node]] += arriving
    edges: list[list[LabelledEdge[LetterSet]]] = [[] for _ in range(size)]
    for target, arriving in enumerate(united):
        for label, marks, source in _uncovered(signature(arriving, leader), above):
            edges[source].append(LabelledEdge(label, marks, target))
    return reachable(edges, graph.marks, leader[0])


def merged_cubes(graph: LabelledGraph[Cube], budget: Budget) -> LabelledGraph[Cube]:
    """The quotient of a graph by simulation, with edges compared one by one.

    Raises:
        TranslationLimit: the budget is spent.
    """
    return merged_cubes_and_simulators(graph, budget)[0]


def merged_cubes_and_simulators(
    graph: LabelledGraph[Cube], budget: Budget
) -> tuple[LabelledGraph[Cube], list[Nodes]]:
    """The quotient by simulation, and for each of its nodes the nodes that simulate it.

    The relation itself is still valid in the quotient.

    Raises:
        TranslationLimit: the budget is spent.
    """
    order, arrows = ordered(graph, budget)
    above = simulators(arrows, [0] * len(arrows), budget)
    budget.spend(sum(len(leaving) ** 2 for leaving in arrows), order.width)
    leader = leaders(above)
    edges: list[list[LabelledEdge[Cube]]] = []
    for leaving in arrows:
        edges.append([])
        for letters, marks, target in _uncovered(signature(leaving, leader), above):
            edges[-1] += [LabelledEdge(cube, marks, target) for cube in order.cubes(letters)]
        edges[-1].sort()
    smaller, number_of = renumbered(edges, graph.marks)
    simulating = [
        sum(1 << number_of[other] for other in indices(above[node]) if other in number_of)
        for node in number_of
    ]
    return smaller, simulating


def _uncovered(signed: Signature, above: Sequence[Nodes]) -> list[LabelledEdge[LetterSet]]:
    """The edges of a signature, each without the letters that a better one reads."""
    edges = [LabelledEdge(letters, *kind) for kind, letters in signed.items()]
    if not overlap(edges):
        return edges
    edges_at: dict[int, list[LabelledEdge[LetterSet]]] = defaultdict(list)
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
    edges: Sequence[Sequence[LabelledEdge[LetterSet]]],
    above: Sequence[Nodes],
    leader: Sequence[int],
) -> list[int]:
    """For each node its leader, or a node further down that accepts the same words.

    The marks of a single edge do not matter. So two nodes accept the same words if their edges
    match except for marks. The second can replace the first if it never leads back to it.
    """
    first_with: dict[frozenset[LabelledEdge[LetterSet]], int] = {}
    chosen = list(leader)
    for component in strong_components([[edge.target for edge in leaving] for leaving in edges]):
        steps = {
            node: frozenset(
                _uncovered(signature((e._replace(marks=0) for e in edges[node]), leader), above)
            )
            for node in component
            if leader[node] == node
        }
        for node, step in steps.items():
            chosen[node] = first_with.get(step, node)
        for node, step in steps.items():
            first_with.setdefault(step, node)
    return [chosen[node] for node in leader]
