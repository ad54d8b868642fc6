"""The mission's frame settles while the vehicle stands, and is kept after that."""

from __future__ import annotations

from random import Random

import pytest

from companion.geometry import Ned, distance
from companion.vehicle.mission_frame import SETTLING_S, MissionFrame
from sitl.flight.estimate import Wander

PLACE: Ned = (3.0, -1.0, -2.0)
TICK_S = 0.05


def stand(frame: MissionFrame, positions: list[Ned], start_s: float = 0.0) -> None:
    for tick, position in enumerate(positions):
        frame.take_position(start_s + tick * TICK_S, position, is_standing=True)


def at_home(home: Ned = (10.0, 20.0, 0.1)) -> MissionFrame:
    frame = MissionFrame()
    frame.take_home(home, 488.0)
    return frame


def test_a_vehicle_that_stands_where_it_should_needs_no_time_and_moves_nothing() -> None:
    frame = at_home()
    stand(frame, [(13.01, 19.0, 0.1)])
    gap_m = frame.gap_m(PLACE, 0.05)
    assert gap_m is not None and gap_m < 0.02
    frame.lay(PLACE)
    assert frame.origin == (10.0, 20.0, 0.1)


def test_an_estimate_that_wanders_is_averaged_before_anything_is_said() -> None:
    frame = at_home()
    stand(frame, [(13.3, 19.0, 0.1)] * 100)
    assert frame.gap_m(PLACE, 0.05) is None
    stand(frame, [(13.3, 19.2, 0.3)] * 110, start_s=5.0)
    gap_m = frame.gap_m(PLACE, 0.05)
    assert gap_m == pytest.approx(0.32, abs=0.02)
    frame.lay(PLACE)
    assert frame.origin == pytest.approx((10.3, 20.1, 0.2), abs=0.02)
    assert frame.altitude_m == pytest.approx(487.9, abs=0.02)


def test_the_frame_is_nearer_to_the_truth_than_one_sample() -> None:
    def errors(seed: int) -> tuple[float, float]:
        wander = Wander(0.25, 0.3).level_error(Random(seed))
        heard: list[Ned] = []
        for _ in range(round(2 * SETTLING_S / TICK_S)):
            wander.step(TICK_S)
            north, east = wander.position
            heard.append((north, east, 0.0))
        frame = at_home(heard[0])
        stand(frame, heard)
        frame.lay((0.0, 0.0, -2.0))
        assert frame.origin is not None
        return distance(heard[0], (0, 0, 0)) ** 2, distance(frame.origin, (0, 0, 0)) ** 2

    first, settled = map(sum, zip(*map(errors, range(100)), strict=True))
    assert settled < 0.5 * first


def test_the_frame_is_kept_where_the_vehicle_lands_and_arms_again() -> None:
    frame = at_home()
    stand(frame, [(13.2, 19.0, 0.1)] * 300)
    frame.lay(PLACE)
    laid = frame.origin
    frame.take_position(20.0, (18.0, 25.0, -2.0), is_standing=False)
    frame.take_home((18.0, 25.0, 0.0), 488.0)
    stand(frame, [(18.0, 25.0, 0.0)] * 300, start_s=30.0)
    frame.lay(PLACE)
    assert frame.origin == laid
    gap_m = frame.gap_m(PLACE, 0.05)
    assert gap_m is not None and gap_m > 5.0


def test_a_vehicle_that_was_carried_settles_anew() -> None:
    frame = at_home()
    stand(frame, [(18.0, 25.0, 0.1)] * 300)
    frame.take_position(16.0, (13.2, 19.0, 0.1), is_standing=True)
    assert frame.gap_m(PLACE, 0.05) is None


def test_a_position_that_is_not_exact_is_averaged_wherever_the_vehicle_seems_to_stand() -> None:
    """The first HOME_POSITION is the estimate of the same moment: no gap, and yet it is off."""
    frame = at_home()
    stand(frame, [(13.0, 19.0, 0.1)] * 20)
    assert frame.gap_m(PLACE, 0.05) is not None
    assert frame.gap_m(PLACE, 0.25) is None
    stand(frame, [(13.0, 19.0, 0.1)] * 200, start_s=1.0)
    assert frame.gap_m(PLACE, 0.25) is not None


def test_the_frame_is_moved_only_after_it_was_laid_and_only_so_far() -> None:
    frame = at_home()
    frame.move((1.0, 0.0), 0.75)
    assert frame.origin == (10.0, 20.0, 0.1)
    stand(frame, [(13.0, 19.0, 0.1)])
    frame.lay(PLACE)
    for _ in range(20):
        frame.move((0.1, -0.05), 0.75)
    assert frame.origin is not None
    north, east, down = frame.origin
    assert (north, east, down) == pytest.approx((10.0 - 0.6, 20.0 + 0.3, 0.1))
