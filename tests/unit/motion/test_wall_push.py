"""What a setpoint is moved by for a vehicle that flies beside it, near to walls."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.geometry import NorthEast
from companion.motion.grid import OccupancyGrid
from companion.motion.trajectory import AT_REST, Sample
from companion.motion.wall_push import MOST_M, REACH_SHARE, STILL, push

CELL_M, KEPT_M, CARROT_M = 0.1, 1.2, 1.5
PER_S, TICK_S = 0.95, 0.05
"""A PX4's gain from a gap to a velocity (MPC_XY_P)."""
OFF_MPS = 0.3
"""What the velocity of its estimate was off by."""


def hall(*pillars: tuple[int, int]) -> OccupancyGrid:
    """6 x 6 m, walled in, with pillars of 0.6 m, by their south-west cells."""
    occupied = np.zeros((60, 60), dtype=np.bool_)
    occupied[[0, -1]] = occupied[:, [0, -1]] = True
    for row, col in pillars:
        occupied[row : row + 6, col : col + 6] = True
    return OccupancyGrid(occupied, CELL_M, (0.0, 0.0))


def passage(cells: int) -> OccupancyGrid:
    """A passage to the north, so many cells wide, from east 3.0 m on."""
    occupied = np.ones((60, 60), dtype=np.bool_)
    occupied[:, 30 : 30 + cells] = False
    return OccupancyGrid(occupied, CELL_M, (0.0, 0.0))


PILLARS = hall((20, 20), (35, 32))
inside = st.floats(0.2, 5.8)
points = st.tuples(inside, inside)
speeds = st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))


def told(at: NorthEast, velocity: NorthEast = (0.0, 0.0)) -> Sample:
    return Sample((*at, -2.0), (*velocity, 0.0), AT_REST, is_finished=False)


def pushed(
    walls: OccupancyGrid, vehicle: NorthEast, setpoint: NorthEast, velocity: NorthEast = (0.0, 0.0)
) -> NorthEast:
    return push(walls, KEPT_M, (*vehicle, -2.0), told(setpoint, velocity), CARROT_M)


def drift(walls: OccupancyGrid, setpoint: NorthEast, off: NorthEast, share: float) -> NorthEast:
    """Where a vehicle with a velocity that is off comes to rest; with a share of the push."""
    north, east = setpoint
    for _ in range(400):
        by = pushed(walls, (north, east), setpoint)
        v_north = PER_S * (setpoint[0] + share * by[0] - north) + off[0]
        v_east = PER_S * (setpoint[1] + share * by[1] - east) + off[1]
        north, east = north + v_north * TICK_S, east + v_east * TICK_S
    return north, east


@given(points, speeds)
def test_a_vehicle_on_its_route_is_moved_by_nothing_however_near_a_wall_is(
    at: NorthEast, velocity: NorthEast
) -> None:
    assert pushed(PILLARS, at, at, velocity) == STILL


@given(points, points, speeds)
def test_a_setpoint_is_moved_away_from_the_wall_and_within_bounds(
    vehicle: NorthEast, setpoint: NorthEast, velocity: NorthEast
) -> None:
    by = pushed(PILLARS, vehicle, setpoint, velocity)
    if by == STILL:
        return
    assert math.hypot(*by) <= MOST_M + 1e-9
    moved = (setpoint[0] + by[0], setpoint[1] + by[1])
    assert math.dist(moved, vehicle) <= REACH_SHARE * CARROT_M + 1e-9
    assert math.dist(setpoint, vehicle) <= REACH_SHARE * CARROT_M


@given(points, st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5)))
def test_one_that_is_as_far_from_walls_as_its_setpoint_is_not_moved(
    setpoint: NorthEast, gap: NorthEast
) -> None:
    vehicle = (setpoint[0] + gap[0], setpoint[1] + gap[1])
    if PILLARS.clearance_m(vehicle) >= PILLARS.clearance_m(setpoint) + CELL_M:
        assert pushed(PILLARS, vehicle, setpoint) == STILL


@pytest.mark.parametrize("bearing_deg", range(0, 360, 30))
def test_one_that_drifts_towards_a_pillar_comes_less_than_half_as_far(bearing_deg: int) -> None:
    walls, middle, bearing = hall((27, 27)), (3.0, 3.0), math.radians(bearing_deg)
    out = (math.cos(bearing), math.sin(bearing))
    setpoint = (middle[0] + 1.0 * out[0], middle[1] + 1.0 * out[1])
    off = (-OFF_MPS * out[0], -OFF_MPS * out[1])
    free, kept = (drift(walls, setpoint, off, share) for share in (0.0, 1.0))
    least_m = walls.clearance_m(setpoint)
    assert least_m - walls.clearance_m(free) > 0.25
    assert least_m - walls.clearance_m(kept) < 0.16


@pytest.mark.parametrize("cells", [8, 12, 13, 20])
@pytest.mark.parametrize("off_mps", [OFF_MPS, -OFF_MPS])
def test_in_a_passage_of_any_width_it_comes_to_rest_on_its_own_side(
    cells: int, off_mps: float
) -> None:
    walls, middle_m = passage(cells), 3.0 + cells * CELL_M / 2
    _, free_m = drift(walls, (3.0, middle_m), (0.0, off_mps), share=0.0)
    _, kept_m = drift(walls, (3.0, middle_m), (0.0, off_mps), share=1.0)
    assert 0.0 < (kept_m - middle_m) / off_mps < 0.55 * (free_m - middle_m) / off_mps


def test_what_it_is_off_by_is_made_up_for_before_a_pillar_is_there() -> None:
    walls, velocity = hall((27, 27)), (2.0, 0.0)
    beside, ahead, past = (3.0, 3.9), (1.0, 3.9), (4.5, 3.9)
    off = 0.3
    now, early, late = (
        pushed(walls, (at[0], at[1] - off), at, velocity) for at in (beside, ahead, past)
    )
    assert now[1] == pytest.approx(MOST_M)
    assert early[0] == 0.0 and early[1] == pytest.approx(MOST_M)  # across its way alone
    assert late == STILL


def test_off_the_map_and_without_walls_it_is_moved_by_nothing() -> None:
    nothing = OccupancyGrid(np.zeros((9, 9), dtype=np.bool_), 1.0, (0.0, 0.0), is_open=True)
    assert pushed(nothing, (4.0, 4.0), (4.5, 4.0)) == STILL
    assert pushed(PILLARS, (-1.0, 3.0), (0.3, 3.0)) == STILL
    assert pushed(PILLARS, (0.02, 3.0), (0.8, 3.0)) == STILL
