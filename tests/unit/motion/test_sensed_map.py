"""How many scans it takes to believe in an obstacle, to give one up, and to doubt a told wall."""

from __future__ import annotations

import math

import numpy as np
import pytest

from companion.motion.grid import OccupancyGrid
from companion.motion.range_scan import REACH_M, RangeScan
from companion.motion.sensed_map import SensedMap

BEAMS = 72
STEP_RAD = 2 * math.pi / BEAMS
MIDDLE = (10.05, 10.05)  # the centre of cell (100, 100)
AHEAD = (120, 100)  # the cell 2 m north of there


def told(*occupied: tuple[int, int], cell_m: float = 0.1) -> SensedMap:
    """An empty map of 200 x 200 cells, but for some."""
    cells = np.zeros((200, 200), dtype=np.bool_)
    for cell in occupied:
        cells[cell] = True
    return SensedMap(OccupancyGrid(cells, cell_m, (0.0, 0.0)))


def scan(ahead_m: float = math.inf, other_m: float = math.inf, first_rad: float = 0.0) -> RangeScan:
    """One distance along the first beam, another along all others."""
    distances_m = np.full(BEAMS, other_m)
    distances_m[0] = ahead_m
    return RangeScan(0.0, MIDDLE, distances_m, first_rad, STEP_RAD, 12.0)


def cells(known: SensedMap) -> set[tuple[int, int]]:
    return {(row, col) for row, col in np.argwhere(known.grid.occupied).tolist()}


def test_one_echo_is_none_and_two_are_an_obstacle() -> None:
    known = told()
    assert not known.integrate(scan(1.95)) and cells(known) == set()
    assert known.integrate(scan(1.95)) and cells(known) == {AHEAD}
    assert not known.integrate(scan(1.95))


def test_a_beam_through_the_place_between_two_echoes_does_not_count_as_a_third() -> None:
    known = told()
    changes = [known.integrate(scan(ahead_m)) for ahead_m in (1.95, math.inf, math.inf, 1.95)]
    assert changes == [False] * 4 and cells(known) == set()


def test_an_obstacle_that_has_gone_is_free_after_nine_scans_however_long_it_was_there() -> None:
    known = told()
    for _ in range(500):
        known.integrate(scan(1.95))
    changes = [known.integrate(scan()) for _ in range(9)]
    assert changes == [False] * 8 + [True] and cells(known) == set()


def test_the_heading_turns_the_scan() -> None:
    known = told()
    for _ in range(2):
        known.integrate(scan(1.95, first_rad=math.pi / 2))
    assert cells(known) == {(100, 120)}


def test_an_echo_beside_a_told_wall_is_that_wall_and_one_further_off_is_not() -> None:
    wall = (123, 100)
    known = told(wall)
    for _ in range(9):
        known.integrate(scan(2.15))  # 0.1 m before it
    assert cells(known) == {wall}
    for _ in range(2):
        known.integrate(scan(1.95))  # 0.3 m before it
    assert cells(known) == {wall, AHEAD}


def test_a_told_wall_is_given_up_only_after_seconds() -> None:
    known = told(AHEAD)
    changes = [known.integrate(scan()) for _ in range(25)]
    assert changes == [False] * 24 + [True] and cells(known) == set()


@pytest.mark.parametrize("beside", [1, -1])
def test_a_beam_beside_one_that_ends_earlier_frees_nothing(beside: int) -> None:
    """As at a wall that is grazed, or at a corner that is looked past."""
    known = told(AHEAD)
    grazing = scan()
    grazing.distances_m[beside] = 1.5
    for _ in range(100):
        known.integrate(grazing)
    assert AHEAD in cells(known)


@pytest.mark.parametrize("nothing", [math.nan, 0.0])
def test_what_is_not_known_frees_nothing(nothing: float) -> None:
    known = told(AHEAD)
    for _ in range(100):
        known.integrate(scan(nothing, nothing))
    assert AHEAD in cells(known)


def test_echoes_from_afar_and_off_the_map_are_left_out() -> None:
    known = told()
    north = np.full(BEAMS, math.nan)
    north[0] = 3.0
    for _ in range(5):
        known.integrate(scan(REACH_M + 0.05))
        known.integrate(RangeScan(0.0, (19.0, 10.0), north, 0.0, STEP_RAD, 12.0))
    assert cells(known) == set()


def test_the_told_map_is_not_changed() -> None:
    grid = OccupancyGrid(np.zeros((200, 200), dtype=np.bool_), 0.1, (0.0, 0.0))
    known = SensedMap(grid)
    for _ in range(2):
        known.integrate(scan(1.95))
    assert not grid.occupied.any() and known.grid is not grid


def test_half_a_scan_turns_to_the_left_if_its_step_is_negative() -> None:
    known = told((120, 100), (100, 120), (100, 80))
    half = RangeScan(0.0, MIDDLE, np.full(37, math.inf), 0.0, -STEP_RAD, 12.0)
    for _ in range(30):
        known.integrate(half)
    assert cells(known) & {(100, 120), (100, 80)} == {(100, 120)}  # west was seen through
