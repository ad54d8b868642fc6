"""Ways in a product: as long as scipy says, and made of edges that are there."""

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

from companion.planning.builtin.product import Product, Restrictions
from companion.planning.builtin.rounds import FAR
from companion.planning.builtin.system import Vocabulary
from companion.planning.builtin.ways import Stride, Ways
from companion.planning.lasso import Problem

TASKS = [
    "G F at(A) & G F at(B)",
    "F (at(A) & X at(B))",
    "F G at(A)",
    "F at(A) & G (at(B) -> X at(H))",
]


def product(asked: Problem) -> Product:
    return Product(asked, Vocabulary(asked.actions), Restrictions())


def on_a_random_map(task: str, seed: int = 1) -> Product:
    places = "HABC"
    legs = random_legs(random.Random(seed), places, is_symmetric=False)
    return product(problem(places, legs, task))


def network(made: Product) -> networkx.DiGraph:
    graph = networkx.DiGraph()
    graph.add_nodes_from(range(made.nodes))
    for node in range(made.nodes):
        graph.add_weighted_edges_from((node, target, cost) for target, cost, _ in made.edges(node))
    return graph


def cost_of(made: Product, start: int, strides: list[Stride]) -> int:
    """Of strides that follow each other from a node along edges of the product."""
    node = start
    for stride in strides:
        assert (stride.node, stride.cost_ms, stride.action) in made.edges(node)
        node = stride.node
    return sum(stride.cost_ms for stride in strides)


@pytest.mark.parametrize("task", TASKS)
def test_costs_and_walks_are_shortest_ways(task: str) -> None:
    made = on_a_random_map(task)
    ways, nodes = Ways(made), range(made.nodes)
    least = dict(networkx.all_pairs_dijkstra_path_length(network(made)))
    to, out_of = ways.to(nodes), ways.out_of(nodes)
    for a, b in itertools.product(nodes, repeat=2):
        assert to[b][a] == out_of[a][b] == least[a].get(b, FAR)
        if a != b and b in least[a]:
            walked = ways.walk(a, b, to[b])
            assert walked[-1].node == b
            assert cost_of(made, a, walked) == least[a][b]


@pytest.mark.parametrize("task", TASKS)
def test_a_turn_is_the_shortest_cycle(task: str) -> None:
    made = on_a_random_map(task)
    ways = Ways(made)
    least = dict(networkx.all_pairs_dijkstra_path_length(network(made)))
    for node in range(made.nodes):
        (to_node,) = ways.to([node])
        expected = min(c + least[t].get(node, FAR) for t, c, _ in made.edges(node))
        assert min(ways.turn_ms(node, to_node), FAR) == min(expected, FAR)
        if expected < FAR:
            walked = ways.walk(node, node, to_node)
            assert walked[-1].node == node
            assert cost_of(made, node, walked) == expected


@pytest.mark.parametrize("task", TASKS)
def test_a_node_is_arrived_at_or_a_twin_of_it(task: str) -> None:
    made = on_a_random_map(task)
    ways = Ways(made)
    least = networkx.multi_source_dijkstra_path_length(network(made), set(made.roots))
    for node in range(made.nodes):
        twins = [n for n in range(made.nodes) if made.twins[n] == made.twins[node]]
        assert ways.arrivals[node] == min(least[twin] for twin in twins)
        walked = ways.arrival(node)
        assert not walked or walked[-1].node in twins
        starts = [r for r in made.roots if not walked or _follows(made, r, walked[0])]
        assert starts
        assert cost_of(made, starts[0], walked) == ways.arrivals[node]


def test_a_twin_that_is_found_later_may_be_nearer() -> None:
    """Nodes 1 and 2 are twins, 2 is reached at less cost; 3 follows both."""
    edges = [[(1, 500, 0), (2, 300, 1)], [(3, 100, 2)], [(3, 100, 2)], []]
    cells = [(a, b, cost) for a, leaving in enumerate(edges) for b, cost, _ in leaving]
    rows, columns, costs = zip(*cells, strict=True)
    stand_in = SimpleNamespace(
        nodes=4,
        roots=[0],
        twins=[0, 1, 1, 3],
        edges=edges.__getitem__,
        graph=lambda: csr_array((np.array(costs, float), (rows, columns)), shape=(4, 4)),
    )
    ways = Ways(cast(Product, stand_in))
    assert ways.arrivals.tolist() == [0, 300, 300, 400]
    assert ways.arrival(1) == ways.arrival(2) == [Stride(1, 300, 2)]


def _follows(made: Product, root: int, stride: Stride) -> bool:
    return (stride.node, stride.cost_ms, stride.action) in made.edges(root)


def test_of_equal_ways_the_one_of_the_earlier_actions_is_taken() -> None:
    made = product(problem("HABC", unit_legs("HABC"), "F (at(A) & X at(C))"))
    ways = Ways(made)
    for goal in range(made.nodes):
        (to_goal,) = ways.to([goal])
        for node in range(made.nodes):
            if node != goal and to_goal[node] < FAR:
                first = ways.walk(node, goal, to_goal)[0].action
                others = [a for t, c, a in made.edges(node) if c + to_goal[t] == to_goal[node]]
                assert first == min(others)


def test_where_no_way_leads_it_is_far() -> None:
    made = product(asking("F done", [action("do", "!done", "done")], [()]))
    ways = Ways(made)
    first, last = made.roots[0], made.nodes - 1
    assert ways.out_of([last])[0][first] == FAR
    assert ways.turn_ms(last, ways.to([last])[0]) == FAR
