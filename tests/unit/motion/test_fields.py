"""Cost fields: closed form on an open floor, and moves that are taken out."""

from __future__ import annotations

import math

import networkx as nx
import numpy as np
import pytest

from companion.motion.fields import MoveGraph
from companion.motion.sight import Sight

NONE = np.empty(0, dtype=np.int_)


def test_an_open_floor_has_the_closed_form_of_sixteen_moves() -> None:
    cost = MoveGraph(np.ones((9, 12), dtype=np.bool_)).field((4, 5), NONE).cost
    for row, col in np.ndindex(9, 12):
        short, long = sorted((abs(row - 4), abs(col - 5)))
        # Straight moves and knight's moves up to slope 1/2, knight's and diagonal moves above.
        if 2 * short <= long:
            expected = (long - 2 * short) + short * math.sqrt(5)
        else:
            expected = (long - short) * math.sqrt(5) + (2 * short - long) * math.sqrt(2)
        assert cost[row, col] == pytest.approx(expected)


def test_a_path_leads_from_its_start_to_the_goal() -> None:
    free = np.ones((5, 7), dtype=np.bool_)
    free[1:, 3] = False
    field = MoveGraph(free).field((4, 6), NONE)
    path = field.path((4, 0))
    assert path[0].tolist() == [4, 0]
    assert path[-1].tolist() == [4, 6]
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    assert steps.sum() == pytest.approx(field.cost[4, 0])


@pytest.mark.parametrize("seed", range(5))
def test_costs_are_those_of_all_moves_with_a_clear_line_of_sight(seed: int) -> None:
    free = np.random.default_rng(seed).random((9, 9)) < 0.7
    sight, cells = Sight(free), np.argwhere(free).astype(np.float64)
    moves = nx.Graph()
    moves.add_nodes_from(map(tuple, np.argwhere(free).tolist()))
    for a in cells:
        for b in cells:
            length = math.dist(a, b)
            if length in (1.0, math.sqrt(2), math.sqrt(5)) and sight.is_clear(a + 0.5, b + 0.5):
                moves.add_edge(
                    tuple(a.astype(int).tolist()), tuple(b.astype(int).tolist()), weight=length
                )
    goal = (int(cells[0, 0]), int(cells[0, 1]))
    expected = np.full(free.shape, np.inf)
    for cell, cost in nx.single_source_dijkstra_path_length(moves, goal).items():
        expected[cell] = cost
    np.testing.assert_allclose(MoveGraph(free).field(goal, NONE).cost, expected)


def test_no_move_cuts_the_corner_of_a_cell_that_is_not_free() -> None:
    free = np.array([[True, True], [False, True]])
    assert MoveGraph(free).field((0, 0), NONE).cost[1, 1] == pytest.approx(2.0)
    assert np.isinf(MoveGraph(np.eye(2, dtype=np.bool_)).field((0, 0), NONE).cost[1, 1])


def test_a_region_without_the_moves_into_it_can_be_left_only() -> None:
    graph = MoveGraph(np.ones((9, 20), dtype=np.bool_))
    entering = graph.entering(np.array([4.5, 10.5]), 3.0)
    out = graph.field((4, 0), entering)
    assert out.cost[4, 10] == pytest.approx(10.0)  # from the middle straight on to the goal
    assert out.cost[4, 19] > 19.0  # from beyond it around
    into = graph.field((4, 10), entering)
    assert np.isfinite(into.cost[4, 11])
    assert np.isinf(into.cost[4, 0])


def test_a_region_beside_the_map_takes_no_move() -> None:
    graph = MoveGraph(np.ones((3, 3), dtype=np.bool_))
    assert graph.entering(np.array([-50.0, 1.0]), 2.0).size == 0
    assert graph.entering(np.array([1.0, 50.0]), 2.0).size == 0
