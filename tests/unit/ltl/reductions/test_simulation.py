"""Simulation and bisimulation, against their definitions."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import pytest
from drawn_graphs import by_letters, graphs_of_cubes
from hypothesis import given

from companion.ltl.bitsets import indices
from companion.ltl.budget import Budget, TranslationLimit
from companion.ltl.graph import LabelledEdge, LabelledGraph
from companion.ltl.labels import Cube, L, LetterSet
from companion.ltl.reductions.bisimulation import bisimilar
from companion.ltl.reductions.quotient import merged_cubes_and_simulators
from companion.ltl.reductions.simulation import cube_simulators, simulators

Pairs = set[tuple[int, int]]
Match = Callable[[LabelledEdge[L], Sequence[LabelledEdge[L]], Pairs], bool]


def greatest(edges: Sequence[Sequence[LabelledEdge[L]]], pairs: Pairs, match: Match[L]) -> Pairs:
    """The pairs (node, simulator) that are left when those without a match are gone."""
    while True:
        left = {(n, s) for n, s in pairs if all(match(e, edges[s], pairs) for e in edges[n])}
        if left == pairs:
            return pairs
        pairs = left


def is_better(one: LabelledEdge[L], other: LabelledEdge[L], pairs: Pairs) -> bool:
    return one.marks & other.marks == other.marks and (other.target, one.target) in pairs


def matched_by_letters(
    edge: LabelledEdge[LetterSet], leaving: Sequence[LabelledEdge[LetterSet]], pairs: Pairs
) -> bool:
    letters = (LetterSet(1 << i) for i in indices(int(edge.label)))
    return all(any(e.label & x and is_better(e, edge, pairs) for e in leaving) for x in letters)


def matched_by_one_edge(
    edge: LabelledEdge[Cube], leaving: Sequence[LabelledEdge[Cube]], pairs: Pairs
) -> bool:
    return any(e.label & edge.label == e.label and is_better(e, edge, pairs) for e in leaving)


def all_pairs(size: int) -> Pairs:
    return {(one, other) for one in range(size) for other in range(size)}


def as_pairs(above: Sequence[int]) -> Pairs:
    return {(node, other) for node, better in enumerate(above) for other in indices(better)}


@pytest.mark.slow
@given(graphs_of_cubes())
def test_a_node_simulates_another_letter_by_letter(drawn: LabelledGraph[Cube]) -> None:
    graph = by_letters(drawn)
    size = len(graph.edges)
    expected = greatest(graph.edges, all_pairs(size), matched_by_letters)
    assert as_pairs(simulators(graph.edges, [0] * size, Budget())) == expected


@given(graphs_of_cubes())
def test_a_colour_asks_for_all_its_bits(drawn: LabelledGraph[Cube]) -> None:
    graph = by_letters(drawn)
    size = len(graph.edges)
    colours = [node % 3 for node in range(size)]
    possible = {(n, s) for n, s in all_pairs(size) if colours[n] & ~colours[s] == 0}
    expected = greatest(graph.edges, possible, matched_by_letters)
    assert as_pairs(simulators(graph.edges, colours, Budget())) == expected


@given(graphs_of_cubes())
def test_with_cubes_an_edge_is_matched_by_one_other(graph: LabelledGraph[Cube]) -> None:
    expected = greatest(graph.edges, all_pairs(len(graph.edges)), matched_by_one_edge)
    assert as_pairs(cube_simulators(graph, Budget())) == expected


@given(graphs_of_cubes())
def test_bisimilar_nodes_do_the_same_in_each_step(drawn: LabelledGraph[Cube]) -> None:
    edges = by_letters(drawn).edges

    def steps(node: int, equal: Pairs) -> set[tuple[int, int, frozenset[int]]]:
        """Letter, marks, and the class of the target, for each edge and letter."""
        return {
            (letter, e.marks, frozenset(t for s, t in equal if s == e.target))
            for e in edges[node]
            for letter in indices(int(e.label))
        }

    finer, equal = all_pairs(len(edges)), Pairs()
    while finer != equal:
        equal = finer
        finer = {(one, other) for one, other in equal if steps(one, equal) == steps(other, equal)}
    assert as_pairs(bisimilar(edges, [0] * len(edges), Budget())) == equal


@given(graphs_of_cubes())
def test_a_quotient_keeps_the_relation(graph: LabelledGraph[Cube]) -> None:
    smaller, above = merged_cubes_and_simulators(graph, Budget())
    assert above == cube_simulators(smaller, Budget())


def test_a_spent_budget_ends_the_comparison() -> None:
    arrows = [[LabelledEdge(LetterSet(1), 0, node)] for node in range(9)]
    for relation in (bisimilar, simulators):
        with pytest.raises(TranslationLimit, match="more than 2 steps"):
            relation(arrows, [0] * 9, Budget(steps=2))
