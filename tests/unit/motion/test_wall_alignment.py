"""Scans laid onto told walls: what a position is wrong by, and what says nothing of that."""

from __future__ import annotations

import math
from dataclasses import replace
from random import Random

import numpy as np
import pytest

from companion.geometry import NorthEast
from companion.motion.grid import OccupancyGrid
from companion.motion.range_scan import RangeScan
from companion.motion.wall_alignment import NONE, WallAlignment
from sitl.world.lidar import STEP_RAD, Lidar, LidarSpec

CELL_M = 0.1
GREATEST_M = 0.9


def room(*boxes: tuple[slice, slice]) -> OccupancyGrid:
    """8 m by 10 m with walls of two cells, and boxes in it."""
    occupied = np.zeros((80, 100), dtype=np.bool_)
    occupied[:2] = occupied[-2:] = occupied[:, :2] = occupied[:, -2:] = True
    for box in boxes:
        occupied[box] = True
    return OccupancyGrid(occupied, CELL_M, (0.0, 0.0))


PILLAR = (slice(30, 40), slice(60, 64))


def scan(
    world: OccupancyGrid,
    truly: NorthEast,
    off_by: NorthEast,
    seed: int = 1,
    turned_rad: float = 0.0,
) -> RangeScan:
    """What a lidar with 2 cm of noise sees, placed where the vehicle is taken to be."""
    distances_m = Lidar(LidarSpec(noise_m=0.02), world, Random(seed)).scan(truly, 0.3)
    taken = (truly[0] + off_by[0], truly[1] + off_by[1])
    return RangeScan(0.0, taken, distances_m, 0.3 + turned_rad, STEP_RAD, 12.0)


@pytest.mark.parametrize("turned_deg", [-10.0, 0.0, 10.0])
@pytest.mark.parametrize("seed", range(12))
def test_the_displacement_is_what_position_and_heading_are_off_by(
    seed: int, turned_deg: float
) -> None:
    chance = Random(seed)
    told = room(PILLAR)
    truly = (chance.uniform(1.5, 6.5), chance.uniform(1.5, 5.0))
    angle, away_m = chance.uniform(0, 2 * math.pi), chance.uniform(0.0, 0.5)
    off_by = (away_m * math.cos(angle), away_m * math.sin(angle))
    seen = scan(told, truly, off_by, seed, math.radians(turned_deg))
    off = WallAlignment(told).displacement(seen, GREATEST_M)
    assert math.hypot(off.north_m + off_by[0], off.east_m + off_by[1]) < 0.06
    assert math.degrees(off.turn_rad) == pytest.approx(-turned_deg, abs=1.0)


def test_what_no_map_shows_does_not_count() -> None:
    """A crate, and a door that is closed: neither moves the vehicle."""
    told, crate = room(), (slice(20, 30), slice(30, 40))
    seen = scan(room(crate), (5.0, 5.0), (0.3, -0.2))
    off = WallAlignment(told).displacement(seen, GREATEST_M)
    assert math.hypot(off.north_m + 0.3, off.east_m - 0.2) < 0.06


def test_along_a_corridor_nothing_is_changed() -> None:
    occupied = np.zeros((30, 600), dtype=np.bool_)
    occupied[:2] = occupied[-2:] = True
    told = OccupancyGrid(occupied, CELL_M, (0.0, 0.0))
    seen = scan(told, (1.5, 30.0), (0.2, 0.5))
    off = WallAlignment(told).displacement(seen, GREATEST_M)
    assert off.north_m == pytest.approx(-0.2, abs=0.05)
    assert off.east_m == pytest.approx(0.0, abs=0.05)


def test_a_scan_of_a_few_echoes_or_of_none_says_nothing() -> None:
    told = room()
    seen = scan(told, (4.0, 5.0), (0.3, 0.0))
    some = np.full_like(seen.distances_m, math.inf)
    some[:5] = seen.distances_m[:5]
    for distances_m in (some, np.full_like(some, math.nan)):
        thin = replace(seen, distances_m=distances_m)
        assert WallAlignment(told).displacement(thin, GREATEST_M) is NONE


def test_a_map_without_walls_says_nothing() -> None:
    told = OccupancyGrid(np.zeros((80, 100), dtype=np.bool_), CELL_M, (0.0, 0.0))
    seen = scan(room(PILLAR), (4.0, 5.0), (0.3, 0.0))
    assert WallAlignment(told).displacement(seen, GREATEST_M) is NONE


def test_no_more_is_told_than_the_position_may_be_off_by() -> None:
    told = room(PILLAR)
    seen = scan(told, (4.0, 4.0), (0.6, 0.0))
    assert WallAlignment(told).displacement(seen, 0.3) is NONE
