"""A cost-to-go repaired after any changes of the map, in any parts, is that of the map then."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
import pytest
from discs import disc
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st

from companion.motion import cost_to_go as module
from companion.motion.cost_to_go import (
    CostToGo,
    adapted,
    begun,
    continued,
    cost_to_go,
    repaired,
)
from companion.motion.grid_graph import GridGraph, edges_entering, grid_graph, union

FAST = drawn(100)
SHAPE = (24, 31)
GOAL = (11, 9)

Mask = npt.NDArray[np.bool_]


@pytest.fixture(autouse=True, scope="module")
def small_tiles() -> Iterator[None]:
    """The maps are small, and have many tiles all the same."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "_TILE", 5)
        yield


@st.composite
def boxes(draw: st.DrawFn) -> Mask:
    """Cells of a box, from a single one to a wall through the whole map."""
    size = draw(st.sampled_from([(1, 1), (3, 3), (6, 2), (SHAPE[0], 1), (2, SHAPE[1]), (9, 12)]))
    row, col = (draw(st.integers(-1, edge - 1)) for edge in SHAPE)
    mask = np.zeros(SHAPE, dtype=np.bool_)
    mask[max(row, 0) : max(row, 0) + size[0], max(col, 0) : max(col, 0) + size[1]] = True
    return mask


@st.composite
def maps(draw: st.DrawFn) -> list[Mask]:
    """One map after the other: in each step boxes close or open, or cells here and there."""
    noise = np.random.default_rng(draw(st.integers(0, 99)))
    free = noise.random(SHAPE) < draw(st.sampled_from([1.0, 0.97, 0.8, 0.6]))
    steps = []
    for _ in range(draw(st.integers(1, 5))):
        for box, is_open in draw(st.lists(st.tuples(boxes(), st.booleans()), max_size=3)):
            free = free | box if is_open else free & ~box
        if draw(st.booleans()):
            free = free ^ (noise.random(SHAPE) < 0.02)
        free = free.copy()
        free[GOAL] = True
        steps.append(free)
    return steps


@st.composite
def barred(draw: st.DrawFn) -> GridGraph:
    """The edges into some discs."""
    centres = st.tuples(st.floats(0, SHAPE[0]), st.floats(0, SHAPE[1])).map(np.array)
    discs = draw(st.lists(st.tuples(centres, st.floats(0.5, 6.0)), max_size=3))
    return union((edges_entering(SHAPE, disc(*each)) for each in discs), SHAPE)


def walked(to_go: CostToGo, start: int) -> list[int]:
    """The cells on the path that `next_cell` shows."""
    path = [start]
    while to_go.next_cell[path[-1]] != path[-1]:
        path.append(int(to_go.next_cell[path[-1]]))
        assert len(path) <= to_go.next_cell.size
    return path


@FAST
@given(maps(), barred())
def test_a_repaired_cost_to_go_is_that_of_the_map(frees: list[Mask], without: GridGraph) -> None:
    first, *others = (grid_graph(free).without(without) for free in frees)
    to_go = cost_to_go(first, GOAL)
    for graph in others:
        to_go, new = repaired(to_go, graph), cost_to_go(graph, GOAL)
        np.testing.assert_allclose(to_go.cost, new.cost, rtol=0, atol=1e-9)
        has_path = np.isfinite(new.cost)
        for row, col in np.argwhere(has_path)[::7].tolist():
            assert to_go.path((row, col)).tolist() == new.path((row, col)).tolist()


@FAST
@given(maps(), barred())
def test_next_cells_are_a_tree_of_shortest_paths(frees: list[Mask], without: GridGraph) -> None:
    first, *others = (grid_graph(free).without(without) for free in frees)
    to_go = cost_to_go(first, GOAL)
    for graph in others:
        to_go = repaired(to_go, graph)
    cost, cells = to_go.cost.ravel(), np.arange(to_go.next_cell.size)
    ends, lengths = to_go.graph.successors(cells)
    for cell in cells.tolist():
        following = int(to_go.next_cell[cell])
        if following == cell:
            assert cost[cell] == 0 or np.isinf(cost[cell])
        else:
            (edge,) = np.flatnonzero(ends[cell] == following)
            assert abs(cost[cell] - cost[following] - lengths[cell, edge]) < 1e-9
    farthest = int(np.argmax(np.where(np.isfinite(cost), cost, -1.0)))
    assert walked(to_go, farthest)[-1] == GOAL[0] * SHAPE[1] + GOAL[1]


@FAST
@given(maps(), barred())
def test_no_edge_makes_a_path_shorter(frees: list[Mask], without: GridGraph) -> None:
    """The equation of Bellman, without a search to compare with."""
    to_go = cost_to_go(grid_graph(frees[0]).without(without), GOAL)
    for free in frees[1:]:
        to_go = repaired(to_go, grid_graph(free).without(without))
    ends, lengths = to_go.graph.successors(np.arange(to_go.next_cell.size))
    cost = to_go.cost.ravel()
    costs = (cost.take(ends, mode="clip") + lengths).min(axis=1).reshape(SHAPE)
    costs[GOAL] = 0.0
    np.testing.assert_allclose(to_go.cost, costs, rtol=0, atol=1e-9)


@drawn(60)
@given(maps(), barred(), st.integers(1, 200))
def test_what_is_final_in_an_unfinished_search_stays(
    frees: list[Mask], without: GridGraph, part: int
) -> None:
    """After each part, and where the map changes before the search has ended."""
    graphs = [grid_graph(free).without(without) for free in frees]
    to_go, anew = begun(graphs[0], GOAL), [cost_to_go(graph, GOAL) for graph in graphs]
    for graph, new in zip(graphs, anew, strict=True):
        to_go = adapted(to_go, graph)
        for _ in range(3):
            final = [(r, c) for r, c in np.ndindex(SHAPE) if to_go.is_final((r, c))]
            assert final
            costs, right = ([each.cost[cell] for cell in final] for each in (to_go, new))
            np.testing.assert_allclose(costs, right, rtol=0, atol=1e-9)
            for cell in (cell for cell in final[::11] if np.isfinite(new.cost[cell])):
                assert to_go.path(cell).tolist() == new.path(cell).tolist()
            to_go = continued(to_go, part)
    while not to_go.is_final():
        to_go = continued(to_go, part)
    np.testing.assert_allclose(to_go.cost, anew[-1].cost, rtol=0, atol=1e-9)


@FAST
@given(maps(), st.integers(0, SHAPE[0] - 1), st.integers(0, SHAPE[1] - 1))
def test_a_search_for_one_cell_ends_with_its_cost(frees: list[Mask], row: int, col: int) -> None:
    graph = grid_graph(frees[0])
    to_go = continued(begun(graph, GOAL), module.ALL, (row, col))
    assert to_go.is_final((row, col))
    np.testing.assert_allclose(to_go.cost[row, col], cost_to_go(graph, GOAL).cost[row, col])
