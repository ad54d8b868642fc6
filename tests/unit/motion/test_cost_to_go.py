"""Cost-to-go: closed form on an open floor, edges that are taken out, what a repair searches."""

from __future__ import annotations

import math

import networkx as nx
import numpy as np
import numpy.typing as npt
import pytest
from discs import disc

from companion.motion.cost_to_go import (
    CostToGo,
    adapted,
    begun,
    continued,
    cost_to_go,
    repaired,
)
from companion.motion.grid_graph import Cell, edges_entering, grid_graph, overlap, union
from companion.motion.line_of_sight import LineOfSight


def on_map(free: npt.NDArray[np.bool_], goal: Cell) -> CostToGo:
    return cost_to_go(grid_graph(free), goal)


def test_an_open_floor_has_the_closed_form_of_sixteen_edges() -> None:
    cost = on_map(np.ones((9, 12), dtype=np.bool_), (4, 5)).cost
    for row, col in np.ndindex(9, 12):
        short, long = sorted((abs(row - 4), abs(col - 5)))
        # Straight edges and knight's moves up to slope 1/2, knight's moves and diagonals above.
        if 2 * short <= long:
            expected = (long - 2 * short) + short * math.sqrt(5)
        else:
            expected = (long - short) * math.sqrt(5) + (2 * short - long) * math.sqrt(2)
        assert cost[row, col] == pytest.approx(expected)


def test_a_path_leads_from_its_start_to_the_goal() -> None:
    free = np.ones((5, 7), dtype=np.bool_)
    free[1:, 3] = False
    to_go = on_map(free, (4, 6))
    path = to_go.path((4, 0))
    assert path[0].tolist() == [4, 0]
    assert path[-1].tolist() == [4, 6]
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    assert steps.sum() == pytest.approx(to_go.cost[4, 0])


@pytest.mark.parametrize("seed", range(5))
def test_costs_are_those_of_all_edges_with_a_clear_line_of_sight(seed: int) -> None:
    free = np.random.default_rng(seed).random((9, 9)) < 0.7
    sight, cells = LineOfSight(free), np.argwhere(free).astype(np.float64)
    graph = nx.Graph()
    graph.add_nodes_from(map(tuple, np.argwhere(free).tolist()))
    for a in cells:
        for b in cells:
            length = math.dist(a, b)
            if length in (1.0, math.sqrt(2), math.sqrt(5)) and sight.is_clear(a + 0.5, b + 0.5):
                graph.add_edge(
                    tuple(a.astype(int).tolist()), tuple(b.astype(int).tolist()), weight=length
                )
    goal = (int(cells[0, 0]), int(cells[0, 1]))
    expected = np.full(free.shape, np.inf)
    for cell, cost in nx.single_source_dijkstra_path_length(graph, goal).items():
        expected[cell] = cost
    np.testing.assert_allclose(on_map(free, goal).cost, expected)


def test_no_edge_cuts_the_corner_of_a_cell_that_is_not_free() -> None:
    free = np.array([[True, True], [False, True]])
    assert on_map(free, (0, 0)).cost[1, 1] == pytest.approx(2.0)
    assert np.isinf(on_map(np.eye(2, dtype=np.bool_), (0, 0)).cost[1, 1])


def test_a_region_without_the_edges_into_it_can_be_left_only() -> None:
    free = np.ones((9, 20), dtype=np.bool_)
    graph = grid_graph(free).without(edges_entering(free.shape, disc((4.5, 10.5), 3.0)))
    out = cost_to_go(graph, (4, 0))
    assert out.cost[4, 10] == pytest.approx(10.0)  # from the middle straight on to the goal
    assert out.cost[4, 19] > 19.0  # from beyond it around
    into = cost_to_go(graph, (4, 10))
    assert np.isfinite(into.cost[4, 11])
    assert np.isinf(into.cost[4, 0])


def test_a_region_beside_the_map_is_entered_by_no_edge() -> None:
    for centre in ([-50.0, 1.0], [1.0, 50.0]):
        assert not edges_entering((3, 3), disc(centre, 2.0)).incoming.any()


def test_edges_are_seen_alike_from_both_ends() -> None:
    """Also those that enter one region alone: outgoing at a cell is incoming at another one."""
    shape = (12, 15)
    discs = [(np.array([4.0, 5.0]), 2.5), (np.array([7.5, 7.5]), 3.0)]
    entering = union((edges_entering(shape, disc(*each)) for each in discs), shape)
    free = np.random.default_rng(0).random(shape) < 0.9
    graph, cells = grid_graph(free).without(entering), np.arange(free.size)
    (ends, there), (starts, back) = graph.successors(cells), graph.predecessors(cells)
    outgoing = {(int(a), int(b)) for a in cells for b in ends[a][np.isfinite(there[a])]}
    incoming = {(int(a), int(b)) for b in cells for a in starts[b][np.isfinite(back[b])]}
    assert outgoing == incoming
    assert len(outgoing) < np.isfinite(grid_graph(free).successors(cells)[1]).sum()


def test_a_repair_searches_where_paths_have_changed_alone() -> None:
    """A crate in a hall comes and goes: a tenth of the hall lies behind it, or less."""
    hall = np.ones((160, 240), dtype=np.bool_)
    crate = hall.copy()
    crate[100:116, 150:166] = False
    empty = on_map(hall, (20, 20))
    filled = repaired(empty, grid_graph(crate))
    assert 0 < filled.searched < 0.1 * empty.searched
    cleared = repaired(filled, grid_graph(hall))
    assert 0 < cleared.searched < 0.15 * empty.searched
    assert repaired(cleared, grid_graph(hall)).searched == 0


def test_edges_into_several_regions_are_their_overlap() -> None:
    """What is barred to the paths to a place: the edges into all other regions."""
    shape = (20, 20)
    discs = [((8.0, 8.0), 4.0), ((8.0, 12.0), 4.0), ((11.0, 10.0), 3.5), ((3.0, 17.0), 2.0)]
    entering = [edges_entering(shape, disc(centre, radius)) for centre, radius in discs]
    every, several = union(entering, shape), overlap(entering, shape)
    assert several.outgoing.any()
    for own in entering:
        others = union((edges for edges in entering if edges is not own), shape)
        barred = every.without(own.without(several))
        assert np.array_equal(barred.outgoing, others.outgoing)
        assert np.array_equal(barred.incoming, others.incoming)


PART = 3000  # cells


def hall_with_walls() -> npt.NDArray[np.bool_]:
    """Three walls that leave a gap each, now on one side and now on the other."""
    free = np.ones((200, 300), dtype=np.bool_)
    free[:150, 75] = free[50:, 150] = free[:150, 225] = False
    return free


@pytest.mark.parametrize("goal", [(5, 5), (100, 149), (199, 299)])
def test_a_search_in_parts_searches_nearly_every_cell_once(goal: Cell) -> None:
    free = hall_with_walls()
    to_go, parts = begun(grid_graph(free), goal), [0]
    while not to_go.is_final():
        to_go = continued(to_go, PART)
        parts.append(to_go.searched)
    assert max(np.diff(parts)) <= PART + 400  # a tile more
    assert free.sum() - 1 <= to_go.searched <= 1.15 * free.sum()
    np.testing.assert_allclose(to_go.cost, cost_to_go(grid_graph(free), goal).cost)


def test_a_repair_close_to_the_goal_is_done_in_parts_as_well() -> None:
    """A door beside the goal closes: nearly all paths are lost."""
    hall = hall_with_walls()
    closed = hall.copy()
    closed[150:185, 75] = False
    to_go = adapted(on_map(hall, (160, 20)), grid_graph(closed))
    before = to_go.searched
    to_go = continued(to_go, PART)
    assert 0 < to_go.searched - before <= PART + 400
    assert not to_go.is_final() and to_go.is_final((170, 20))
    while not to_go.is_final():
        to_go = continued(to_go, PART)
    np.testing.assert_allclose(to_go.cost, on_map(closed, (160, 20)).cost)


def test_a_cell_near_the_goal_takes_a_small_search() -> None:
    graph = grid_graph(hall_with_walls())
    near = continued(begun(graph, (100, 20)), 10**9, (110, 40))
    assert near.is_final((110, 40)) and not near.is_final()
    assert near.searched < 0.1 * cost_to_go(graph, (100, 20)).searched
