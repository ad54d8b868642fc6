"""Cost fields: closed form on an open floor, moves that are taken out, what a repair searches."""

from __future__ import annotations

import math

import networkx as nx
import numpy as np
import numpy.typing as npt
import pytest

from companion.motion.fields import Field, repaired, searched
from companion.motion.moves import Cell, all_of, moves_between, moves_entering
from companion.motion.sight import Sight


def field_of(free: npt.NDArray[np.bool_], goal: Cell) -> Field:
    return searched(moves_between(free), goal)


def test_an_open_floor_has_the_closed_form_of_sixteen_moves() -> None:
    cost = field_of(np.ones((9, 12), dtype=np.bool_), (4, 5)).cost
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
    field = field_of(free, (4, 6))
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
    np.testing.assert_allclose(field_of(free, goal).cost, expected)


def test_no_move_cuts_the_corner_of_a_cell_that_is_not_free() -> None:
    free = np.array([[True, True], [False, True]])
    assert field_of(free, (0, 0)).cost[1, 1] == pytest.approx(2.0)
    assert np.isinf(field_of(np.eye(2, dtype=np.bool_), (0, 0)).cost[1, 1])


def test_a_region_without_the_moves_into_it_can_be_left_only() -> None:
    free = np.ones((9, 20), dtype=np.bool_)
    moves = moves_between(free).without(moves_entering(free.shape, np.array([4.5, 10.5]), 3.0))
    out = searched(moves, (4, 0))
    assert out.cost[4, 10] == pytest.approx(10.0)  # from the middle straight on to the goal
    assert out.cost[4, 19] > 19.0  # from beyond it around
    into = searched(moves, (4, 10))
    assert np.isfinite(into.cost[4, 11])
    assert np.isinf(into.cost[4, 0])


def test_a_region_beside_the_map_takes_no_move() -> None:
    for centre in ([-50.0, 1.0], [1.0, 50.0]):
        assert not moves_entering((3, 3), np.array(centre), 2.0).onto.any()


def test_moves_are_seen_alike_from_both_ends() -> None:
    """Also those that lead into one region alone: away from a cell is onto another one."""
    shape = (12, 15)
    discs = [(np.array([4.0, 5.0]), 2.5), (np.array([7.5, 7.5]), 3.0)]
    entering = all_of((moves_entering(shape, *disc) for disc in discs), shape)
    free = np.random.default_rng(0).random(shape) < 0.9
    moves, cells = moves_between(free).without(entering), np.arange(free.size)
    (left, left_by), (reached, reached_by) = moves.leading_away(cells), moves.leading_onto(cells)
    away = {(a, int(b)) for a in cells for b in left[a][np.isfinite(left_by[a])]}
    onto = {(int(a), b) for b in cells for a in reached[b][np.isfinite(reached_by[b])]}
    assert away == onto
    assert len(away) < np.isfinite(moves_between(free).leading_away(cells)[1]).sum()


def test_a_repair_searches_where_ways_have_changed_alone() -> None:
    """A crate in a hall comes and goes: a tenth of the hall lies behind it, or less."""
    hall = np.ones((160, 240), dtype=np.bool_)
    crate = hall.copy()
    crate[100:116, 150:166] = False
    empty = field_of(hall, (20, 20))
    filled = repaired(empty, moves_between(crate))
    assert 0 < filled.searched < 0.1 * empty.searched
    cleared = repaired(filled, moves_between(hall))
    assert 0 < cleared.searched < 0.15 * empty.searched
    assert repaired(cleared, moves_between(hall)).searched == 0
