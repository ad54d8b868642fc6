"""Fields repaired after any changes of the map are those of the map as it is then."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from hypothesis import given, settings
from hypothesis import strategies as st

from companion.motion.fields import Field, repaired, searched
from companion.motion.moves import Moves, all_of, moves_between, moves_entering

FAST = settings(max_examples=150, deadline=None, derandomize=True)
SHAPE = (24, 31)
GOAL = (11, 9)

Mask = npt.NDArray[np.bool_]


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
def barred(draw: st.DrawFn) -> Moves:
    """The moves into some discs."""
    centres = st.tuples(st.floats(0, SHAPE[0]), st.floats(0, SHAPE[1])).map(np.array)
    discs = draw(st.lists(st.tuples(centres, st.floats(0.5, 6.0)), max_size=3))
    return all_of((moves_entering(SHAPE, *disc) for disc in discs), SHAPE)


def walked(field: Field, start: int) -> list[int]:
    """The cells on the way that `onward` shows."""
    way = [start]
    while field.onward[way[-1]] != way[-1]:
        way.append(int(field.onward[way[-1]]))
        assert len(way) <= field.onward.size
    return way


@FAST
@given(maps(), barred())
def test_a_repaired_field_is_that_of_the_map(frees: list[Mask], without: Moves) -> None:
    first, *others = (moves_between(free).without(without) for free in frees)
    field = searched(first, GOAL)
    for moves in others:
        field, new = repaired(field, moves), searched(moves, GOAL)
        np.testing.assert_allclose(field.cost, new.cost, rtol=0, atol=1e-9)
        has_way = np.isfinite(new.cost)
        for row, col in np.argwhere(has_way)[::7].tolist():
            assert field.path((row, col)).tolist() == new.path((row, col)).tolist()


@FAST
@given(maps(), barred())
def test_onward_is_a_tree_of_shortest_ways(frees: list[Mask], without: Moves) -> None:
    first, *others = (moves_between(free).without(without) for free in frees)
    field = searched(first, GOAL)
    for moves in others:
        field = repaired(field, moves)
    cost, cells = field.cost.ravel(), np.arange(field.onward.size)
    ends, lengths = field.moves.leading_away(cells)
    for cell in cells.tolist():
        onward = int(field.onward[cell])
        if onward == cell:
            assert cost[cell] == 0 or np.isinf(cost[cell])
        else:
            (move,) = np.flatnonzero(ends[cell] == onward)
            assert abs(cost[cell] - cost[onward] - lengths[cell, move]) < 1e-9
    farthest = int(np.argmax(np.where(np.isfinite(cost), cost, -1.0)))
    assert walked(field, farthest)[-1] == GOAL[0] * SHAPE[1] + GOAL[1]


@FAST
@given(maps(), barred())
def test_no_move_makes_a_way_shorter(frees: list[Mask], without: Moves) -> None:
    """The equation of Bellman, without a search to compare with."""
    field = searched(moves_between(frees[0]).without(without), GOAL)
    for free in frees[1:]:
        field = repaired(field, moves_between(free).without(without))
    ends, lengths = field.moves.leading_away(np.arange(field.onward.size))
    cost = field.cost.ravel()
    ways = (cost.take(ends, mode="clip") + lengths).min(axis=1).reshape(SHAPE)
    ways[GOAL] = 0.0
    np.testing.assert_allclose(field.cost, ways, rtol=0, atol=1e-9)
