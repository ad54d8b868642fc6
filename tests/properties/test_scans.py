"""Scans of random worlds by the simulator's lidar: what they make of a map, whatever it was told.

The lidar is exact and tested against its own authority; here it is the witness.
"""

from __future__ import annotations

import math
from dataclasses import replace
from random import Random
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from drawn import drawn
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy import ndimage

from companion.geometry import NorthEast
from companion.motion.grid import OccupancyGrid
from companion.motion.range_scan import REACH_M, RangeScan
from companion.motion.sensed_map import SensedMap
from sitl.flight.physics import STANDING_M
from sitl.world.lidar import STEP_RAD, Lidar, LidarSpec

FAST = drawn(25)
EDGE, CELL_M = 60, 0.1
Bools = npt.NDArray[np.bool_]


class Lean(NamedTuple):
    """How a vehicle hangs in the air.

    Attributes:
        up_m: its height above the ground.
        error_m: by what it is taken to be higher.
    """

    up_m: float = 1.0
    error_m: float = 0.0
    roll_rad: float = 0.0
    pitch_rad: float = 0.0


LEVEL = Lean()
TILT = st.floats(-0.6, 0.6)
LEANS = st.builds(Lean, st.floats(0.0, 3.0), st.floats(-1.0, 1.0), TILT, TILT)


@st.composite
def boxes(draw: st.DrawFn, most: int = 4) -> Bools:
    """(EDGE, EDGE) cells of some boxes."""
    occupied = np.zeros((EDGE, EDGE), dtype=np.bool_)
    for _ in range(draw(st.integers(1, most))):
        row, col = draw(st.integers(0, EDGE - 3)), draw(st.integers(0, EDGE - 3))
        height, width = draw(st.integers(2, 12)), draw(st.integers(2, 12))
        occupied[row : row + height, col : col + width] = True
    return occupied


def free_positions(occupied: Bools, count: int, seed: int) -> list[NorthEast]:
    """Positions somewhere in cells that are three away from anything."""
    padded = np.pad(occupied, 1, constant_values=True)
    cells = np.argwhere(ndimage.distance_transform_edt(~padded)[1:-1, 1:-1] >= 3)
    assume(len(cells) > 0)
    chance = Random(seed)
    chosen = [chance.choice(cells.tolist()) for _ in range(count)]
    return [((r + chance.random()) * CELL_M, (c + chance.random()) * CELL_M) for r, c in chosen]


def world(occupied: Bools) -> OccupancyGrid:
    return OccupancyGrid(occupied, CELL_M, (0.0, 0.0))


def scan_of(lidar: Lidar, position: NorthEast, yaw_rad: float, lean: Lean = LEVEL) -> RangeScan:
    """As it comes off the wire: whole centimetres."""
    tilt_rad = lean.roll_rad, lean.pitch_rad
    seen_m = lidar.scan(position, yaw_rad, lean.up_m + STANDING_M, tilt_rad)
    return RangeScan(
        0.0,
        position,
        distances_m=np.rint(100 * seen_m) / 100,
        first_rad=0.0,
        step_rad=STEP_RAD,
        range_m=lidar.spec.range_m,
        up_m=lean.up_m + lean.error_m,
        yaw_rad=yaw_rad,
        tilt_rad=tilt_rad,
        height_error_m=max(lean.error_m, 0.0),
    )


def a_lidar(occupied: Bools, noise_m: float = 0.0) -> Lidar:
    return Lidar(LidarSpec(noise_m=noise_m), world(occupied), Random(1))


def seen_from(occupied: Bools, told: Bools, seed: int, lean: Lean = LEVEL) -> SensedMap:
    """The map after four scans from each of some positions, at all headings."""
    lidar, known = a_lidar(occupied), SensedMap(world(told))
    for i, position in enumerate(free_positions(occupied, 6, seed)):
        for yaw_rad in (0.0, 0.02, 0.04, 0.06):
            for _ in range(2):
                known.integrate(scan_of(lidar, position, i + yaw_rad, lean))
    return known


@FAST
@given(boxes(), st.integers(0, 99), LEANS)
def test_nothing_is_marked_two_cells_from_anything(occupied: Bools, seed: int, lean: Lean) -> None:
    """However the vehicle leans, however low it is, with a height that is off by a metre."""
    known = seen_from(occupied, np.zeros_like(occupied), seed, lean)
    padded = np.pad(occupied, 2, constant_values=True)
    away = ndimage.distance_transform_edt(~padded)[2:-2, 2:-2]
    assert away[known.grid.occupied].max(initial=0.0) < 2


@FAST
@given(boxes(), st.integers(0, 99))
def test_every_face_that_two_scans_have_met_is_found(occupied: Bools, seed: int) -> None:
    """The cell behind each echo, or one next to it, whatever was told to be free there."""
    known = SensedMap(world(np.zeros_like(occupied)))
    lidar = a_lidar(occupied)
    (position,) = free_positions(occupied, 1, seed)
    scan = scan_of(lidar, position, 0.3)
    known.integrate(scan)
    assert not known.grid.occupied.any()
    known.integrate(scan)
    near = ndimage.binary_dilation(np.pad(known.grid.occupied, 1), np.ones((3, 3), bool))[
        1:-1, 1:-1
    ]
    for i, distance_m in enumerate(scan.distances_m.tolist()):
        angle = 0.3 + i * STEP_RAD
        north = position[0] + (distance_m + 0.01) * math.cos(angle)
        east = position[1] + (distance_m + 0.01) * math.sin(angle)
        row, col = math.floor(north / CELL_M), math.floor(east / CELL_M)
        is_inside = 3 <= min(row, col) and max(row, col) < EDGE - 3  # away from the outer walls
        if distance_m <= REACH_M and is_inside:
            assert near[row, col]


@FAST
@given(boxes(), st.integers(0, 99), st.sampled_from([0.0, 0.02]), LEANS)
def test_a_map_that_is_true_is_left_as_it_is(
    occupied: Bools, seed: int, noise_m: float, lean: Lean
) -> None:
    """Noise of 2 cm, a position that is off by 5 cm, a heading by 2 degrees: no cell changes."""
    lidar, known = a_lidar(occupied, noise_m), SensedMap(world(occupied))
    for north, east in 4 * free_positions(occupied, 5, seed):
        scan = scan_of(lidar, (north, east), 0.7, lean)
        is_near = scan.distances_m < 2.0  # where 2 degrees are 7 cm
        known.integrate(
            replace(
                scan,
                position=(north + 0.03, east - 0.04),
                yaw_rad=0.735,
                distances_m=np.where(is_near, scan.distances_m, np.nan),
            )
        )
        known.integrate(scan)
    assert np.array_equal(known.grid.occupied, occupied)


@FAST
@given(boxes(most=2), st.integers(0, 99))
def test_what_has_gone_is_free_again(occupied: Bools, seed: int) -> None:
    """An obstacle was seen and then taken away: after nine scans its faces are gone."""
    empty = np.zeros_like(occupied)
    known = SensedMap(world(empty))
    (position,) = free_positions(occupied, 1, seed)
    before = scan_of(a_lidar(occupied), position, 0.0)
    for _ in range(20):
        known.integrate(before)
    after = scan_of(a_lidar(empty), position, 0.0)
    for _ in range(9):
        known.integrate(after)
    middle = slice(EDGE // 4, -EDGE // 4)  # where no beam beside one ends earlier, at a wall
    assert not known.grid.occupied[middle, middle].any()
