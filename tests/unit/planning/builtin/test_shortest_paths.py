"""Paths in a product: as short as networkx says, and made of edges that are there."""

from __future__ import annotations

import itertools
import random
from types import SimpleNamespace
from typing import cast

import networkx
import numpy as np
import pytest
from problems import action, asking, problem, random_legs, unit_legs
from scipy.sparse import csr_array

from companion.planning.builtin.costs import UNREACHABLE_MS
from companion.planning.builtin.masked_actions import KnownActions
from companion.planning.builtin.product import Product
from companion.planning.builtin.restrictions import Restrictions
from companion.planning.builtin.shortest_paths import Edge, ShortestPaths
from companion.planning.lasso import Problem

TASKS = [
    "G F at(A) & G F at(B)",
    "F (at(A) & X at(B))",
    "F G at(A)",
    "F at(A) & G (at(B) -> X at(H))",
]


def product(asked: Problem) -> Product:
    return Product(asked, KnownActions(asked.actions), Restrictions())


def on_a_random_map(task: str, seed: int = 1) -> Product:
    places = "HABC"
    legs = random_legs(random.Random(seed), places, is_symmetric=False)
    return product(problem(places, legs, task))


def network(made: Product) -> networkx.DiGraph:
    graph = networkx.DiGraph()
    graph.add_nodes_from(range(made.nodes))
    for node in range(made.nodes):
        graph.add_weighted_edges_from((node, target, cost) for _, cost, target in made.edges(node))
    return graph


def cost_of(made: Product, start: int, path: list[Edge]) -> int:
    """Of edges of the product that follow each other from a node."""
    node = start
    for edge in path:
        assert edge in made.edges(node)
        node = edge.end
    return sum(edge.cost_ms for edge in path)


@pytest.mark.parametrize("task", TASKS)
def test_costs_and_paths_are_the_shortest(task: str) -> None:
    made = on_a_random_map(task)
    paths, nodes = ShortestPaths(made), range(made.nodes)
    least = dict(networkx.all_pairs_dijkstra_path_length(network(made)))
    costs_to, costs_from = paths.costs_to(nodes), paths.costs_from(nodes)
    for a, b in itertools.product(nodes, repeat=2):
        assert costs_to[b][a] == costs_from[a][b] == least[a].get(b, UNREACHABLE_MS)
        if a != b and b in least[a]:
            path = paths.path(a, b, costs_to[b])
            assert path[-1].end == b
            assert cost_of(made, a, path) == least[a][b]


@pytest.mark.parametrize("task", TASKS)
def test_cycles_are_the_shortest(task: str) -> None:
    made = on_a_random_map(task)
    paths = ShortestPaths(made)
    least = dict(networkx.all_pairs_dijkstra_path_length(network(made)))
    for node in range(made.nodes):
        (to_node,) = paths.costs_to([node])
        expected = min(c + least[t].get(node, UNREACHABLE_MS) for _, c, t in made.edges(node))
        assert min(paths.cycle_ms(node, to_node), UNREACHABLE_MS) == min(expected, UNREACHABLE_MS)
        if expected < UNREACHABLE_MS:
            cycle = paths.path(node, node, to_node)
            assert cycle[-1].end == node
            assert cost_of(made, node, cycle) == expected


@pytest.mark.parametrize("task", TASKS)
def test_a_node_or_another_one_of_its_product_state_is_reached_from_the_start(task: str) -> None:
    made = on_a_random_map(task)
    paths = ShortestPaths(made)
    least = networkx.multi_source_dijkstra_path_length(network(made), set(made.initial))
    for node in range(made.nodes):
        alike = [n for n in range(made.nodes) if made.state_of[n] == made.state_of[node]]
        assert paths.from_start[node] == min(least[other] for other in alike)
        path = paths.path_from_start(node)
        assert not path or path[-1].end in alike
        starts = [n for n in made.initial if not path or path[0] in made.edges(n)]
        assert starts
        assert cost_of(made, starts[0], path) == paths.from_start[node]


def test_a_node_that_is_found_later_may_be_nearer() -> None:
    """Nodes 1 and 2 are of one product state, 2 is reached at less cost; 3 follows both."""
    edges = [[(0, 500, 1), (1, 300, 2)], [(2, 100, 3)], [(2, 100, 3)], []]
    cells = [(a, b, cost) for a, leaving in enumerate(edges) for _, cost, b in leaving]
    rows, columns, costs = zip(*cells, strict=True)
    stand_in = SimpleNamespace(
        nodes=4,
        initial=[0],
        state_of=[0, 1, 1, 3],
        edges=edges.__getitem__,
        cost_matrix=lambda: csr_array((np.array(costs, float), (rows, columns)), shape=(4, 4)),
    )
    paths = ShortestPaths(cast(Product, stand_in))
    assert paths.from_start.tolist() == [0, 300, 300, 400]
    assert paths.path_from_start(1) == paths.path_from_start(2) == [Edge(1, 300, 2)]


def test_of_equal_paths_the_one_of_the_earlier_actions_is_taken() -> None:
    made = product(problem("HABC", unit_legs("HABC"), "F (at(A) & X at(C))"))
    paths = ShortestPaths(made)
    for goal in range(made.nodes):
        (to_goal,) = paths.costs_to([goal])
        for node in range(made.nodes):
            if node != goal and to_goal[node] < UNREACHABLE_MS:
                first = paths.path(node, goal, to_goal)[0].action
                others = [a for a, c, t in made.edges(node) if c + to_goal[t] == to_goal[node]]
                assert first == min(others)


def test_what_no_path_leads_to_is_unreachable() -> None:
    made = product(asking("F done", [action("do", "!done", "done")], [()]))
    paths = ShortestPaths(made)
    first, last = made.initial[0], made.nodes - 1
    assert paths.costs_from([last])[0][first] == UNREACHABLE_MS
    assert paths.cycle_ms(last, paths.costs_to([last])[0]) == UNREACHABLE_MS
