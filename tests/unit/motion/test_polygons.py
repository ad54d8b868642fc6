"""Polygons on the map: which cells they touch, and what is not a polygon."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from polygons import Point, area_in_box, stars

from companion.geometry import is_in_polygon
from companion.motion.polygons import cells_touched, problem_of, segments_meet, without_repeats

SHAPE = (9, 11)
SLIVER = 1e-6
"""Of a cell: with less of it in a polygon either answer is right."""


@given(stars((4.3, 5.6), 0.2, 8.0))
def test_touched_are_the_cells_with_a_part_in_the_polygon(corners: list[Point]) -> None:
    """Clipping knows nothing of rows; the polygon may reach beyond the map on all sides."""
    touched = cells_touched(SHAPE, np.array(corners))
    parts = [
        [area_in_box(corners, (row, col), (row + 1, col + 1)) for col in range(SHAPE[1])]
        for row in range(SHAPE[0])
    ]
    assert not np.any(touched & (np.array(parts) == 0.0) & ~_is_grazed(corners))
    assert np.all(touched[np.array(parts) > SLIVER])


def _is_grazed(corners: list[Point]) -> np.ndarray[tuple[int, int], np.dtype[np.bool_]]:
    """Cells of which the polygon has less than can be computed: within a millionth of it."""
    grown = [
        [
            area_in_box(corners, (row - SLIVER, col - SLIVER), (row + 1 + SLIVER, col + 1 + SLIVER))
            for col in range(SHAPE[1])
        ]
        for row in range(SHAPE[0])
    ]
    return np.array(grown) > 0.0


def test_a_box_along_the_cells_touches_these_alone() -> None:
    box = np.array([(2.0, 3.0), (2.0, 6.0), (4.0, 6.0), (4.0, 3.0)])
    touched = cells_touched(SHAPE, box)
    assert np.argwhere(touched).tolist() == [[r, c] for r in (2, 3) for c in (3, 4, 5)]
    assert cells_touched(SHAPE, box[::-1]).tolist() == touched.tolist()


def test_a_polygon_off_the_map_touches_nothing() -> None:
    away = np.array([(20.0, 3.0), (22.0, 6.0), (21.0, -6.0)])
    assert not cells_touched(SHAPE, away).any()
    assert not cells_touched(SHAPE, away[:, ::-1]).any()


def test_a_polygon_around_the_map_touches_all_of_it() -> None:
    assert cells_touched(SHAPE, np.array([(-1, -1), (-1, 99), (99, 99), (99, -1.0)])).all()


POINT = st.tuples(st.integers(-4, 4), st.integers(-4, 4)).map(lambda p: (float(p[0]), float(p[1])))


@given(POINT, POINT, POINT, POINT)
def test_segments_meet_if_some_point_is_on_both(a: Point, b: Point, c: Point, d: Point) -> None:
    """By Cramer's rule in whole numbers, and by ends that lie on the other segment."""
    met = bool(segments_meet(*(np.array(point) for point in (a, b, c, d))))
    assert met is _have_common_point(a, b, c, d)


def _have_common_point(a: Point, b: Point, c: Point, d: Point) -> bool:
    (ux, uy), (vx, vy), (wx, wy) = ((q[0] - p[0], q[1] - p[1]) for p, q in ((a, b), (c, d), (a, c)))
    det = ux * vy - uy * vx
    if det == 0:
        ends = ((a, c, d), (b, c, d), (c, a, b), (d, a, b))
        return any(_is_on(*each) for each in ends)
    s, t = (wx * vy - wy * vx) / det, (wx * uy - wy * ux) / det
    return 0 <= s <= 1 and 0 <= t <= 1


def _is_on(point: Point, begin: Point, end: Point) -> bool:
    lengths = [np.hypot(q[0] - p[0], q[1] - p[1]) for p, q in ((begin, point), (point, end))]
    whole = np.hypot(end[0] - begin[0], end[1] - begin[1])
    return bool(abs(sum(lengths) - whole) < 1e-9)


@given(stars((0.0, 0.0), 0.5, 50.0))
def test_stars_are_polygons_whichever_way_they_go(corners: list[Point]) -> None:
    assert problem_of(corners) is None
    assert problem_of(corners[::-1]) is None
    assert is_in_polygon((0.0, 0.0), corners) or len(corners) < 5  # the authority agrees


@pytest.mark.parametrize(
    ("corners", "problem"),
    [
        ([(0, 0), (1, 1)], "it has 2 corners, at least 3 are needed"),
        ([(0, 0), (4, 4), (1, 1)], "it has no area: its corners are on a line"),
        ([(0, 0), (2, 2), (2, 0), (0, 2)], "its edges from corner 1 and from corner 3 cross"),
        ([(0, 0), (4, 0), (4, 4), (2, 0), (0, 4)], "its edges from corner 1 and from corner 3 cr"),
        ([(0, 0), (0, 4), (4, 4), (4, 9), (4, 0)], "its edges from corner 2 and from corner 4 cr"),
    ],
)
def test_what_is_no_polygon(corners: list[Point], problem: str) -> None:
    assert (problem_of(corners) or "").startswith(problem)
    moved = [(1000 + 0.1 * north, 0.1 * east - 2000) for north, east in corners]
    assert problem_of(moved) is not None


def test_the_first_corner_may_stand_at_the_end_too() -> None:
    square = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)]
    assert set(without_repeats([*square, square[0]])) == set(square)
    assert len(without_repeats([*square, square[0]])) == 4
    assert problem_of(without_repeats([*square, square[0]])) is None
    assert without_repeats([(1.0, 2.0)] * 5) == ()
