"""The lidar against a fine ray march and closed forms, and on the wire."""

import math
from random import Random

import numpy as np
import numpy.typing as npt
import pytest
from drawn import drawn
from hypothesis import example, given
from hypothesis import strategies as st
from wire import Wire, companion_heartbeat

from companion.geometry import Quaternion
from companion.motion.grid import LowWalls, OccupancyGrid
from sitl.flight.attitude import quaternion_from_euler
from sitl.world.lidar import BEAMS, STEP_RAD, Lidar, LidarSpec
from sitl.world.scenario import Scenario

MARCH_M = 0.01
Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]


def room(seed: int) -> OccupancyGrid:
    """6 m by 8 m with scattered pillars, free around its middle (0, 0)."""
    occupied = np.random.default_rng(seed).random((60, 80)) < 0.03
    occupied[26:34, 36:44] = False
    return OccupancyGrid(occupied, 0.1, (-3.0, -4.0))


def is_free(grid: OccupancyGrid, north: float, east: float) -> bool:
    row, col = grid.cell((north, east))
    return grid.contains(row, col) and not grid.occupied[row, col]


def touching(grid: OccupancyGrid, north: float, east: float) -> list[bool]:
    """Whether each cell that a point touches is free: a beam may run along a wall."""
    return [is_free(grid, north + a, east + b) for a in (-1e-7, 1e-7) for b in (-1e-7, 1e-7)]


@drawn(6)
@example(0, 0.3, 0.0, 0.0)
@given(st.integers(0, 10**6), st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(-4.0, 4.0))
def test_every_beam_is_free_up_to_its_hit(
    seed: int, north: float, east: float, yaw_rad: float
) -> None:
    """A ray march finds nothing before the hit, and an obstacle right behind it."""
    grid = room(seed)
    scan = Lidar(LidarSpec(), grid, Random(0)).scan((north, east), yaw_rad)
    for i, hit_m in enumerate(scan):
        dn, de = math.cos(yaw_rad + i * STEP_RAD), math.sin(yaw_rad + i * STEP_RAD)
        for step in range(int((hit_m - 1e-6) / MARCH_M)):
            t = step * MARCH_M
            assert any(touching(grid, north + t * dn, east + t * de))
        at = (north + hit_m * dn, east + hit_m * de)
        assert not all(touching(grid, *at))  # a corner may be hit, up to rounding


def turned(attitude: Quaternion, beam: int) -> Floats:
    """(3,) north, east and down along a beam of a vehicle, by its quaternion: q v q*."""
    w, axis = attitude[0], np.array(attitude[1:])
    body = np.array((math.cos(beam * STEP_RAD), math.sin(beam * STEP_RAD), 0.0))
    across = 2 * np.cross(axis, body)
    return body + w * across + np.cross(axis, across)


TILT = st.floats(-0.7, 0.7)


@drawn(40)
@given(st.integers(0, 10**6), st.floats(0.05, 2.9), TILT, TILT, st.floats(-4.0, 4.0))
def test_beams_of_a_vehicle_that_leans_end_at_the_first_thing_they_come_into(
    seed: int, up_m: float, roll: float, pitch: float, yaw: float
) -> None:
    """A march in space: free above the ground and what ends below it, and solid behind the end."""
    tall, random = room(seed), np.random.default_rng(seed)
    tops_m = np.kron(random.choice([0.0, 0.0, 0.5, 1.0, 2.0], (12, 16)), np.ones((5, 5)))
    tops_m[26:34, 36:44] = 0.0
    grid = OccupancyGrid(tall.occupied, 0.1, tall.origin, tall.is_open, LowWalls(tops_m))
    heights_m = np.pad(np.where(grid.occupied, math.inf, tops_m), 1, constant_values=math.inf)

    def is_solid(points: Floats) -> Bools:
        cells = np.floor((points[:2].T - grid.origin) / grid.cell_m).astype(int)
        row, col = np.clip(cells + 1, 0, np.array(heights_m.shape) - 1).T
        solid: Bools = (-points[2] < heights_m[row, col] - 1e-9) | (points[2] > 1e-9)
        return solid

    lidar, start = Lidar(LidarSpec(), grid, Random(0)), np.array((0.013, -0.021, -up_m))
    scan = lidar.scan((start[0], start[1]), yaw, up_m, (roll, pitch))
    for beam, hit_m in enumerate(scan.tolist()):
        assert hit_m < math.inf  # the room is closed
        along = turned(quaternion_from_euler(roll, pitch, yaw), beam)[:, None]
        marched = np.arange(MARCH_M, hit_m - 1e-6, MARCH_M)
        assert not is_solid(start[:, None] + along * marched).any()
        aside = np.array([(a, b, c) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)]).T * 1e-6
        assert is_solid(start[:, None] + along * hit_m + aside).any()


def test_an_empty_hall_is_seen_as_its_walls_are() -> None:
    """10 m by 10 m: along a beam the nearer of the two walls that it approaches."""
    grid = OccupancyGrid(np.zeros((100, 100), dtype=np.bool_), 0.1, (-5.0, -5.0))
    scan = Lidar(LidarSpec(), grid, Random(0)).scan((1.0, -2.0), 0.3)
    for i, seen_m in enumerate(scan):
        dn, de = math.cos(0.3 + i * STEP_RAD), math.sin(0.3 + i * STEP_RAD)
        north_m = ((5.0 if dn > 0 else -5.0) - 1.0) / dn
        east_m = ((5.0 if de > 0 else -5.0) + 2.0) / de
        assert seen_m == pytest.approx(min(north_m, east_m), abs=1e-9)


def test_nothing_is_seen_beyond_the_range_or_without_walls() -> None:
    grid = OccupancyGrid(np.zeros((100, 100), dtype=np.bool_), 0.1, (-5.0, -5.0))
    near = Lidar(LidarSpec(range_m=4.9), grid, Random(0)).scan((0.0, 0.0), 0.0)
    none = Lidar(LidarSpec(), None, Random(0)).scan((0.0, 0.0), 0.0)
    assert near.tolist() == none.tolist() == [math.inf] * BEAMS


def test_who_is_in_a_wall_or_off_the_map_sees_nothing_but_wall() -> None:
    occupied = np.zeros((100, 100), dtype=np.bool_)
    occupied[50, 50] = True
    lidar = Lidar(LidarSpec(), OccupancyGrid(occupied, 0.1, (-5.0, -5.0)), Random(0))
    for position in ((0.05, 0.05), (5.05, 0.0)):
        assert not lidar.scan(position, 0.0).any()


def test_noise_has_its_deviation_and_comes_from_the_seed() -> None:
    grid = OccupancyGrid(np.zeros((100, 100), dtype=np.bool_), 0.1, (-5.0, -5.0))
    exact = Lidar(LidarSpec(), grid, Random(0)).scan((0.0, 0.0), 0.0)
    first, again = (Lidar(LidarSpec(noise_m=0.05), grid, Random(7)) for _ in range(2))
    errors = []
    for _ in range(30):
        scan = first.scan((0.0, 0.0), 0.0)
        assert scan.tolist() == again.scan((0.0, 0.0), 0.0).tolist()
        errors += (scan - exact).tolist()
    assert np.std(errors) == pytest.approx(0.05, rel=0.1)
    assert np.mean(errors) == pytest.approx(0.0, abs=0.005)


def test_the_scan_is_told_in_the_body_frame_at_10_hz() -> None:
    """A wall 5 m to the north lies to the left of a vehicle that looks east: beam 54 of 72."""
    occupied = np.zeros((400, 400), dtype=np.bool_)
    occupied[250:252, :] = True
    grid = OccupancyGrid(occupied, 0.1, (-20.0, -20.0))
    wire = Wire(Scenario(yaw_rad=math.pi / 2, lidar=LidarSpec()), grid)
    wire.send(companion_heartbeat())
    wire.run(1.999)
    scans = [heard.message for heard in wire.named("OBSTACLE_DISTANCE")]
    assert len(scans) == 20
    scan = scans[-1]
    assert (scan.get_srcComponent(), scan.frame, scan.increment) == (196, 12, 5)
    assert (scan.max_distance, len(scan.distances)) == (1200, BEAMS)
    assert scan.distances[54] == pytest.approx(500, abs=2)
    assert scan.distances[18] == 1201
