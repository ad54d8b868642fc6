"""Echoes of a vehicle that leans, against closed forms, and what its beams say of the map."""

from __future__ import annotations

import math

import numpy as np
import pytest
from drawn import drawn
from hypothesis import given
from hypothesis import strategies as st

from companion.motion.grid import OccupancyGrid
from companion.motion.range_scan import REACH_M, Floats, RangeScan, echoes
from companion.motion.sensed_map import SensedMap
from sitl.flight.attitude import quaternion_from_euler

BEAMS, STEP_RAD = 72, math.radians(5.0)
NORTH_M, EAST_M = 4.0, 3.0
"""Where the walls of a hall are, on both sides of a vehicle at (0, 0)."""
TILT = st.floats(-0.6, 0.6)


def along(beam: int, roll: float, pitch: float, yaw: float) -> tuple[float, float, float]:
    """North, east and down along a beam, by the matrix of the vehicle's quaternion."""
    w, x, y, z = quaternion_from_euler(roll, pitch, yaw)
    ahead, right = math.cos(beam * STEP_RAD), math.sin(beam * STEP_RAD)
    return (
        (1 - 2 * (y * y + z * z)) * ahead + 2 * (x * y - w * z) * right,
        2 * (x * y + w * z) * ahead + (1 - 2 * (x * x + z * z)) * right,
        2 * (x * z - w * y) * ahead + 2 * (y * z + w * x) * right,
    )


def scan_of(
    distances_m: Floats, up_m: float, yaw_rad: float, tilt_rad: tuple[float, float]
) -> RangeScan:
    return RangeScan(
        0.0,
        (0.0, 0.0),
        distances_m,
        first_rad=0.0,
        step_rad=STEP_RAD,
        range_m=12.0,
        up_m=up_m,
        yaw_rad=yaw_rad,
        tilt_rad=tilt_rad,
    )


@drawn(100)
@given(st.floats(0.0, 4.0), TILT, TILT, st.floats(-4.0, 4.0))
def test_echoes_are_those_of_walls_above_the_ground_and_not_far_above_the_vehicle(
    up_m: float, roll: float, pitch: float, yaw: float
) -> None:
    distances_m, expected = [], []
    for beam in range(BEAMS):
        north, east, down = along(beam, roll, pitch, yaw)
        to_wall_m = min(NORTH_M / max(abs(north), 1e-9), EAST_M / max(abs(east), 1e-9))
        to_ground_m = (up_m + 0.12) / down if down > 1e-9 else math.inf
        distances_m.append(min(to_wall_m, to_ground_m))
        falls_m = to_wall_m * down
        if to_wall_m < REACH_M and -1.5 < falls_m < max(up_m - 0.3, 0.1):
            expected.append((to_wall_m * north, to_wall_m * east, falls_m - up_m))
    scan = scan_of(np.array(distances_m), up_m, yaw, (roll, pitch))
    assert echoes(scan).T == pytest.approx(np.array(expected).reshape(-1, 3), abs=1e-9)


@drawn(100)
@given(st.floats(0.0, 4.0), TILT, TILT, st.floats(-4.0, 4.0), st.floats(-4.0, 4.0))
def test_sight_ends_where_the_plane_of_beams_comes_near_the_ground(
    up_m: float, roll: float, pitch: float, yaw: float, bearing: float
) -> None:
    """The plane is all that is at right angles to the vehicle's own axis downwards."""
    w, x, y, z = quaternion_from_euler(roll, pitch, yaw)
    axis = 2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)
    toward = math.cos(bearing), math.sin(bearing)
    falls = -(axis[0] * toward[0] + axis[1] * toward[1]) / axis[2]
    room_m = max(up_m - 0.3, 0.1) if falls > 0 else 1.5
    scan = scan_of(np.full(BEAMS, math.inf), up_m, yaw, (roll, pitch))
    assert scan.sight_m(toward) == pytest.approx(min(REACH_M, room_m / max(abs(falls), 1e-9)))


def freed(pitch_deg: float, up_m: float, away_m: float) -> bool:
    """Whether a cell ahead is freed by beams of a vehicle that leans, which meet nothing."""
    empty = np.zeros((200, 200), dtype=np.bool_)
    known = SensedMap(OccupancyGrid(empty, 0.1, (-10.05, -10.05), is_open=True))
    nothing = np.full(BEAMS, math.inf)
    something = nothing.copy()
    something[0] = away_m
    for distances_m, pitch, times in ((something, 0.0, 3), (nothing, math.radians(pitch_deg), 30)):
        scan = RangeScan(
            *(0.0, (0.0, 0.0), distances_m, 0.0, STEP_RAD, 12.0, up_m), tilt_rad=(0.0, pitch)
        )
        for _ in range(times):
            known.integrate(scan)
        if distances_m is something:
            assert known.grid.occupied.sum() == 1
    return not known.grid.occupied.any()


@pytest.mark.parametrize(
    ("pitch_deg", "up_m", "away_m", "is_freed"),
    [
        (0, 0.8, 6.0, True),
        (10, 0.8, 2.0, True),  # 0.35 m above it
        (10, 0.8, 4.0, False),  # 0.7 m above it: it may be lower
        (-10, 2.0, 6.0, True),  # 1 m above the ground
        (-10, 1.0, 2.0, True),
        (-10, 1.0, 5.0, False),  # where the ground may be
    ],
)
def test_a_beam_that_leans_frees_what_it_has_passed_at_its_height(
    pitch_deg: float, up_m: float, away_m: float, is_freed: bool
) -> None:
    assert freed(pitch_deg, up_m, away_m) is is_freed
