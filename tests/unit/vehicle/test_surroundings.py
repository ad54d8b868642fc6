"""Scans correct the map, and the frame where the position is not exact."""

from __future__ import annotations

import math
from random import Random

import numpy as np
import pytest

from companion.geometry import NorthEast
from companion.motion.grid import OccupancyGrid
from companion.motion.position_error import greatest_error_m
from companion.motion.range_scan import RangeScan
from companion.vehicle.surroundings import Surroundings
from companion.vehicle.telemetry import Telemetry
from sitl.world.lidar import STEP_RAD, Lidar, LidarSpec

HERE: NorthEast = (3.0, 4.0)


def room(*boxes: tuple[slice, slice]) -> OccupancyGrid:
    occupied = np.zeros((80, 100), dtype=np.bool_)
    occupied[:2] = occupied[-2:] = occupied[:, :2] = occupied[:, -2:] = True
    occupied[30:40, 60:64] = True
    for box in boxes:
        occupied[box] = True
    return OccupancyGrid(occupied, 0.1, (0.0, 0.0))


class Standing:
    """A vehicle that stands at HERE while its autopilot has it somewhere else."""

    def __init__(self, accuracy_m: float, told: OccupancyGrid, world: OccupancyGrid) -> None:
        self.telemetry = Telemetry()
        self.surroundings = Surroundings(told, self.telemetry)
        self._lidar = Lidar(LidarSpec(noise_m=0.02), world, Random(1))
        frame = self.telemetry.frame
        self.telemetry.accuracy_m = accuracy_m
        frame.take_home((0.0, 0.0, 0.0), 488.0)
        frame.take_position(0.0, (*HERE, 0.0), is_standing=True)
        frame.lay((*HERE, -2.0))

    def scan(self, off_by: NorthEast, turned_rad: float = 0.0, times: int = 1) -> NorthEast:
        """Scans at once by a pose in error; returns what was left of its error before them."""
        origin = self.telemetry.frame.origin
        assert origin is not None
        taken = (HERE[0] + off_by[0] - origin[0], HERE[1] + off_by[1] - origin[1])
        distances_m = self._lidar.scan(HERE, 0.0)
        scan = RangeScan(0.0, taken, distances_m, turned_rad, STEP_RAD, 12.0)
        self.surroundings.take([scan] * times)
        return (taken[0] - HERE[0], taken[1] - HERE[1])


@pytest.mark.parametrize("turned_deg", [0.0, 12.0, -20.0])
def test_a_position_that_is_not_exact_is_corrected_by_the_walls(turned_deg: float) -> None:
    vehicle, told = Standing(0.25, room(), room()), room()
    left = [vehicle.scan((0.4, -0.3), math.radians(turned_deg)) for _ in range(15)]
    assert math.hypot(*left[0]) == pytest.approx(0.5)
    assert math.hypot(*left[-1]) < 0.06
    assert np.array_equal(vehicle.surroundings.grid.occupied, told.occupied)


def test_scans_that_come_at_once_correct_no_more_than_what_is_off() -> None:
    """As after a pause of the process: each of them was placed before any of them had moved it."""
    vehicle = Standing(0.25, room(), room())
    vehicle.scan((0.2, -0.1), times=20)
    assert math.hypot(*vehicle.scan((0.2, -0.1))) < 0.06


def test_a_position_that_is_exact_is_never_corrected() -> None:
    """The walls may be what is wrong."""
    vehicle = Standing(0.05, room(), room())
    left = [vehicle.scan((0.2, 0.1)) for _ in range(15)]
    assert left[-1] == left[0]


def test_the_frame_moves_by_no_more_than_the_position_may_be_off_by() -> None:
    vehicle = Standing(0.15, room(), room())
    for step in range(60):
        vehicle.scan((0.02 * step, 0.0))
    origin = vehicle.telemetry.frame.origin
    assert origin is not None
    assert math.hypot(*origin[:2]) <= greatest_error_m(0.15) + 1e-9


def test_a_door_that_is_closed_is_seen_by_a_position_in_error() -> None:
    """It stands between two told walls, nearer to each than the position is good for."""
    passage = (slice(2, 34), slice(30, 32)), (slice(46, 78), slice(30, 32))
    told, door = room(*passage), (slice(34, 46), slice(30, 32))
    vehicle = Standing(0.35, told, room(*passage, door))
    for _ in range(10):
        vehicle.scan((0.3, 0.3))
    seen = vehicle.surroundings.grid.occupied[36:44, 30:32]
    assert np.count_nonzero(seen) >= 3
    assert not (vehicle.surroundings.grid.occupied & ~told.occupied)[:30, :28].any()
