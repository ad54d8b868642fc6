"""Straight legs against cells and regions, on cases that can be checked by eye."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from companion.motion.line_of_sight import LineOfSight, enters_disc


def sight(*rows: str) -> LineOfSight:
    """Lines of sight over a drawing, its last line southmost; # is blocked."""
    return LineOfSight(np.array([[cell != "#" for cell in row] for row in reversed(rows)]))


def is_clear(over: LineOfSight, a: tuple[float, float], b: tuple[float, float]) -> bool:
    forwards = over.is_clear(np.array(a), np.array(b))
    assert over.is_clear(np.array(b), np.array(a)) == forwards
    return bool(forwards)


@pytest.mark.parametrize(
    ("a", "b", "expected"),
    [
        ((0.5, 0.5), (0.5, 3.5), True),  # along the southmost row
        ((0.5, 0.5), (2.5, 0.5), True),  # along the westmost column
        ((0.5, 0.5), (2.5, 3.5), False),  # through both blocked cells
        ((0.5, 0.5), (0.9, 3.9), True),  # just beneath
        ((0.5, 0.5), (1.0, 1.5), False),  # ends on the edge of a blocked cell
        ((0.5, 1.5), (0.5, 1.5), True),  # a leg of no length
        ((1.5, 1.5), (1.5, 1.5), False),
        ((0.5, 0.5), (0.5, 4.5), False),  # leaves the map
        ((-0.5, 0.5), (0.5, 0.5), False),
        ((99.0, 99.0), (99.0, 99.0), False),
    ],
)
def test_legs_around_a_block(
    a: tuple[float, float], b: tuple[float, float], expected: bool
) -> None:
    over = sight(
        "....",
        ".##.",
        "....",
    )
    assert is_clear(over, a, b) is expected


def test_no_leg_slips_between_cells_that_meet_in_a_corner() -> None:
    over = sight(
        ".#",
        "#.",
    )
    assert not is_clear(over, (0.5, 1.5), (1.5, 0.5))


def test_a_leg_that_touches_a_corner_crosses_that_cell() -> None:
    over = sight(
        "..",
        "#.",
    )
    assert not is_clear(over, (0.5, 1.5), (1.5, 0.5))
    assert is_clear(over, (0.5, 1.5), (1.5, 0.6))


def test_a_nearly_level_leg_on_an_edge_touches_both_rows() -> None:
    over = sight(
        "..#",
        "...",
    )
    assert not is_clear(over, (1.0, 0.5), (1.0, 2.5))
    assert not is_clear(over, (1.0, 0.5), (1.0 + 1e-12, 2.5))
    assert is_clear(over, (1.0 - 1e-6, 0.5), (1.0 - 1e-6, 2.5))


def test_many_legs_at_once_answer_as_each_alone() -> None:
    over = sight("...#....", "......#.", ".#......", "........")
    ends = np.random.default_rng(0).uniform((0, 0), (4, 8), (50, 2))
    start = np.array([0.5, 0.5])
    assert over.is_clear(start, ends).tolist() == [bool(over.is_clear(start, b)) for b in ends]
    assert over.is_clear(start, ends[:0]).shape == (0,)


@pytest.mark.parametrize(
    ("a", "b", "expected"),
    [
        ((-2, 0), (2, 0), True),  # through
        ((-2, 0), (0, 0), True),  # into
        ((0, 0), (2, 0), False),  # out of
        ((-0.5, 0), (0.5, 0), False),  # within
        ((-2, 1), (2, 1), False),  # along the rim
        ((-2, 0.99), (2, 0.99), True),
        ((2, 0), (3, 0), False),  # away, on a line that meets the disc behind the start
        ((-3, 0), (-2, 0), False),  # towards, but stops before
        ((2, 0), (2, 0), False),
    ],
)
def test_entering_a_unit_disc(
    a: tuple[float, float], b: tuple[float, float], expected: bool
) -> None:
    def point(x: tuple[float, float]) -> npt.NDArray[np.float64]:
        return np.array([x[0] + 5.0, x[1] + 7.0])

    assert bool(enters_disc(point(a), point(b), point((0, 0)), 1.0)) is expected
