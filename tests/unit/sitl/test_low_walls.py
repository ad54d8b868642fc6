"""Walls that end somewhere: who hits them, who sees them, and what becomes of the map."""

from __future__ import annotations

import math
from random import Random

import numpy as np
import pytest

from companion.drawn_maps import Wall, walled
from companion.motion.grid import OccupancyGrid
from companion.motion.range_scan import RangeScan
from companion.motion.sensed_map import BELOW_M, SensedMap
from sitl.world.collision import CollisionCounter
from sitl.world.lidar import STEP_RAD, Lidar, LidarSpec

OPEN = OccupancyGrid(np.zeros((100, 100), dtype=np.bool_), 0.1, (-5.0, -5.0), is_open=True)
LOW, LOWER = (
    Wall(((2.0, -5.0), (2.0, 5.0), (2.2, 5.0), (2.2, -5.0)), 2.0),
    Wall(((-2.2, -5.0), (-2.2, 5.0), (-2.0, 5.0), (-2.0, -5.0)), 1.0),
)
GRID = walled(OPEN, [LOW, LOWER])


def test_a_grid_has_a_layer_for_each_height() -> None:
    assert not GRID.occupied.any()
    counts = [int(GRID.at(up_m).occupied.sum()) for up_m in (0.0, 0.99, 1.0, 1.5, 2.0, 9.0)]
    assert counts == [400, 400, 200, 200, 0, 0]
    assert GRID.at(1.0) is GRID.at(1.9)
    high = walled(OPEN, [Wall(LOW.corners), LOW])
    assert high.at(9.0).occupied.sum() == 200


def test_a_low_wall_is_hit_below_its_end() -> None:
    for up_m, is_hit in ((0.5, True), (1.99, True), (2.0, False), (3.0, False)):
        assert CollisionCounter(GRID, 0.35).update((1.9, 0.0, -up_m)) is is_hit
    assert not CollisionCounter(GRID, 0.35).update((1.5, 0.0, -0.5))


@pytest.mark.parametrize(
    ("up_m", "north_m", "south_m"),
    [(0.5, 2.0, 2.0), (1.5, 2.0, math.inf), (2.5, math.inf, math.inf)],
)
def test_the_lidar_looks_over_what_ends_below_it(
    up_m: float, north_m: float, south_m: float
) -> None:
    scan = Lidar(LidarSpec(), GRID, Random(0)).scan((0.0, 0.0), 0.0, up_m)
    assert scan[0] == pytest.approx(north_m)
    assert scan[len(scan) // 2] == pytest.approx(south_m)


def scanned(
    known: SensedMap, truth: OccupancyGrid, up_m: float, tilt_rad: tuple[float, float] = (0.0, 0.0)
) -> None:
    distances_m = Lidar(LidarSpec(), truth, Random(0)).scan((0.0, 0.0), 0.0, up_m + 0.1, tilt_rad)
    scan = RangeScan(
        0.0,
        (0.0, 0.0),
        distances_m,
        first_rad=0.0,
        step_rad=STEP_RAD,
        range_m=12.0,
        up_m=up_m,
        tilt_rad=tilt_rad,
    )
    for _ in range(30):
        known.integrate(scan)


@pytest.mark.parametrize("tilt_rad", [(0.0, 0.0), (0.0, -0.4), (0.0, 0.4), (-0.3, 0.2)])
@pytest.mark.parametrize("up_m", [0.5, 1.5, 1.85, 2.5, 4.0])
def test_what_is_seen_of_a_low_wall_changes_nothing(
    up_m: float, tilt_rad: tuple[float, float]
) -> None:
    """Neither does it grow, nor do beams over it, or onto it, wear it away or add to it."""
    known = SensedMap(GRID)
    scanned(known, GRID, up_m, tilt_rad)
    assert known.grid is GRID


def test_a_new_obstacle_is_seen_beside_a_low_wall_and_high_above_one() -> None:
    pillar = OPEN.occupied.copy()
    pillar[62:64, 50:52] = True  # in front of the wall
    pillar[71, 60:64] = True  # on it
    truth = walled(OPEN.with_occupied(pillar), [LOW])
    for up_m, is_seen_above in ((0.5, False), (2.0 + BELOW_M, True)):
        known = SensedMap(walled(OPEN, [LOW]))
        scanned(known, truth, up_m)
        assert known.grid.occupied[62, 50:52].any()
        assert bool(known.grid.occupied[71, 60:64].any()) is is_seen_above
        assert known.grid.low is not None
        assert known.grid.at(0.5).occupied.sum() >= 200
